"""A sentence changes what a demonstration shows."""

from __future__ import annotations

import pytest
from listening import scene

from ntp_dsl.language.diagnostics.diagnostics import NtpError
from ntp_dsl.semantics.observation import Record
from ntp_dsl.sentences.amending import amended


def placement(item: int, support: int) -> Record:
    return Record("Placement", (("item", f"block_{item}"), ("support", f"block_{support}")))


SHOWN = (placement(1, 2), placement(3, 1), placement(4, 5))


def changed(sentence: str) -> tuple[object, ...]:
    who, _ = scene("block_stacking")
    [after] = amended(who, [SHOWN], sentence)
    assert isinstance(after, tuple)
    return after


@pytest.mark.parametrize(
    "sentence",
    [
        "but put block 3 on block 6",
        "the same, except that block 3 goes on block 6",
        "do it like that, only with block 3 on block 6",
        "block 3 should go on block 6 rather than where I put it",
        "everything stays the same, but block 6 is where block 3 should sit",
    ],
)
def test_another_place_for_what_was_shown(sentence: str) -> None:
    assert changed(sentence) == (placement(1, 2), placement(3, 6), placement(4, 5))


@pytest.mark.parametrize(
    ("sentence", "left"),
    [
        ("leave out the last one", (0, 1)),
        ("do everything but the final move", (0, 1)),
        ("skip the first step", (1, 2)),
        ("the same, but start with the second one", (1, 2)),
        ("leave out the last two", (0,)),
        ("skip block 3", (0, 2)),
        ("do not move block 4", (0, 1)),
        ("do all that, but leave block 1 where it is", (1, 2)),
        ("leave out the first and the last", (1,)),
        ("skip the last but one", (0, 2)),
        ("leave out blocks 3 and 4", (0,)),
        ("do not put block 3 on block 1", (0, 2)),
    ],
)
def test_what_is_left_out(sentence: str, left: tuple[int, ...]) -> None:
    assert changed(sentence) == tuple(SHOWN[each] for each in left)


@pytest.mark.parametrize(
    "sentence",
    ["use block 7 instead of block 4", "replace block 4 with block 7", "take block 7 rather than block 4"],
)
def test_one_object_in_the_place_of_another(sentence: str) -> None:
    assert changed(sentence) == (*SHOWN[:2], placement(7, 5))


@pytest.mark.parametrize(
    "sentence", ["swap block 3 and block 4", "swap blocks 3 and 4", "let block 3 and block 4 change places"]
)
def test_two_objects_change_roles(sentence: str) -> None:
    assert changed(sentence) == (placement(1, 2), placement(4, 1), placement(3, 5))


def test_something_is_added() -> None:
    assert changed("and also put block 6 on block 4") == (*SHOWN, placement(6, 4))


def test_changes_are_made_one_after_the_other() -> None:
    assert changed("swap block 3 and block 4, then leave out the last one") == (
        placement(1, 2),
        placement(4, 1),
    )
    assert changed("skip block 3 and put block 7 on block 1") == (*SHOWN[::2], placement(7, 1))


@pytest.mark.parametrize(
    "sentence",
    [
        "skip block 7",
        "don't leave out the last one",
        "don't swap block 3 and block 4",
        "leave out the last four",
        "leave out the block on block 1",
        "put block 2 on the gherkin",
        "avoid putting block 3 on block 6",
        "hurry up",
        "forget about the second tower",
        "swap two blocks",
        "but put a block on block 6",
    ],
)
def test_what_changes_nothing_or_may_mean_several_is_refused(sentence: str) -> None:
    with pytest.raises(NtpError):
        changed(sentence)
