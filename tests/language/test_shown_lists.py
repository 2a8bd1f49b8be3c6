"""What a demonstration can show of a list is what the program's contract says of its elements."""

from __future__ import annotations

import pytest

from ntp_dsl.language.loader import diagnose_text

HEAD = """library moves
use tabletop
record Move(item: Movable, way: Place, end: Place)
predicate brought(m: Move): on(m.item, m.end)
predicate apart(m: Move, other: Move) by python
"""
TELLING = {
    "all on(m.item, m.end) for m in moves": ["'way' of 'moves'"],
    "all brought(m) for m in moves": ["'way' of 'moves'"],
    "all on(m.item, m.end) and clear(m.way) for m in moves": [],
    "all brought(m) and apart(m, m) for m in moves": [],
    "empty(gripper)": ["no demonstration shows it"],
}


def noted(achieves: str, *needed: str) -> list[str]:
    """Return what is noted of a program that needs some fields of its list."""
    body = "".join(f"    for m in moves:\n        clear(m.{each})\n" for each in needed)
    report = diagnose_text(f"{HEAD}program move(moves: list[Move]):\n    achieves {achieves}\n{body}")
    return [each.message for each in report.diagnostics if each.code in ("N404", "N405")]


@pytest.mark.parametrize("achieves", TELLING)
def test_what_no_contract_mentions_is_noted(achieves: str) -> None:
    found, wanted = noted(achieves, "item", "way", "end"), TELLING[achieves]
    assert len(found) == len(wanted)
    assert all(part in message for part, message in zip(wanted, found, strict=True))


def test_a_field_of_another_list_is_not_taken_for_one_of_this() -> None:
    text = f"""{HEAD}program move(moves: list[Move], more: list[Move]):
    achieves (all brought(m) for m in moves) and (all on(m.item, m.way) for m in more)
    for m in moves:
        clear(m.item)
    for m in more:
        clear(m.way)
"""
    assert not [each for each in diagnose_text(text).diagnostics if each.code in ("N404", "N405")]


def test_a_field_that_the_body_does_not_need_is_not_noted() -> None:
    assert noted("all brought(m) for m in moves", "item", "end") == []
