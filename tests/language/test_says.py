"""`says`: how the calls of a program are said."""

from __future__ import annotations

import pytest

from ntp_dsl.language.formatting.canonical import format_text
from ntp_dsl.language.loader import diagnose_text, load_text

LIBRARY = """library says

use tabletop

program put(item: Movable, support: Place):
    {says}
    requires present(item) and reachable(item) and present(support) and reachable(support)
    achieves on(item, support)
    pick_and_place(item, support)
"""


def codes(text: str) -> set[str]:
    return {each.code for each in diagnose_text(text).diagnostics}


def test_sentences_are_part_of_the_registry_and_not_of_the_hash() -> None:
    said = load_text(LIBRARY.format(says='says "put {item} on {support}", "{support} carries {item}"'))
    silent = load_text(LIBRARY.replace("    {says}\n", ""))
    assert said.programs["put"].says == ("put {item} on {support}", "{support} carries {item}")
    assert said.programs["put"].hash == silent.programs["put"].hash


@pytest.mark.parametrize(
    ("says", "message"),
    [
        ('says "put {item} down"', "does not name {support}"),
        ('says "put {item} on {item} of {support}"', "names {item} twice"),
        ('says "put {itm} on {support}"', "did you mean 'item'?"),
        ('says "put {item on {support}"', "a brace has no partner"),
    ],
)
def test_a_sentence_names_every_object_once(says: str, message: str) -> None:
    found = diagnose_text(LIBRARY.format(says=says)).diagnostics
    assert {each.code for each in found} == {"E411"} and message in found[0].message


def test_two_calls_that_are_said_alike_are_warned_of() -> None:
    text = LIBRARY.format(says='says "see to {item} on {support}"')
    twin = text.split("tabletop")[1].replace("program put", "program lay").replace("Movable", "Block")
    assert "W407" in codes(text + twin)
    assert "W407" not in codes(text + twin.replace("see to", "lay"))


def test_comments_stand_within_the_brackets() -> None:
    text = LIBRARY.format(
        says='says (  # in words\n        # two\n        "put {item} on {support}",  # one\n    )'
    )
    assert codes(text) == set() and format_text(format_text(text)) == format_text(text)


def test_says_stays_a_name_where_no_sentence_follows() -> None:
    text = LIBRARY.replace("    {says}\n", "").replace("put(", "says(")
    assert codes(text) == codes(LIBRARY.replace("    {says}\n", ""))


def test_long_lists_of_sentences_are_broken_in_brackets() -> None:
    many = ", ".join(f'"{word} the {{item}} on the {{support}}"' for word in ("put", "lay", "set", "place"))
    formatted = format_text(LIBRARY.format(says=f"says {many}"))
    assert '    says (\n        "put the {item} on the {support}",\n' in formatted
    assert format_text(formatted) == formatted
