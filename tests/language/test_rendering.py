"""A diagnostic is shown in the source, with related places and the fix."""

from __future__ import annotations

from pathlib import Path

import pytest

from ntp_dsl.language.diagnostics.codes import CODES, FAMILIES
from ntp_dsl.language.diagnostics.diagnostics import Diagnostic, Edit, Fix, Note
from ntp_dsl.language.diagnostics.rendering import changed_lines, plain, render
from ntp_dsl.language.syntax.nodes import Span

A, B = Path("a.ntp"), Path("b.ntp")


def at(line: int, column: int, width: int, path: Path = A) -> Span:
    return Span(path, line, column, line, column + width)


def picture(diagnostic: Diagnostic, **texts: str) -> list[str]:
    sources = {Path(f"{name}.ntp"): text for name, text in texts.items()}
    return plain(render(diagnostic, sources)).split("\n")


def test_the_line_is_shown_with_a_caret_under_the_mistake() -> None:
    mistake = Diagnostic("E103", "there is no type 'Movabel'", at(3, 13, 7), help="there is: T")
    assert picture(mistake, a="library a\nuse tabletop\ntype Cup is Movabel\n") == [
        "error[E103]: there is no type 'Movabel'",
        "  --> a.ntp:3:13",
        "   |",
        " 3 | type Cup is Movabel",
        "   |             ^^^^^^^",
        "   |",
        "   = help: there is: T",
    ]


def test_related_places_are_shown_with_their_own_lines() -> None:
    notes = (Note("declared here", at(1, 5, 1)), Note("and there", at(12, 1, 3, B)), Note("so"))
    mistake = Diagnostic("W301", "twice", at(4, 5, 1), notes)
    text = "api x()\n\n\napi x()\n"
    assert picture(mistake, a=text, b="\n" * 11 + "use c\n") == [
        "warning[W301]: twice",
        "   --> a.ntp:4:5",
        "    |",
        "  1 | api x()",
        "    |     - declared here",
        "...",
        "  4 | api x()",
        "    |     ^",
        "    |",
        "   ::: b.ntp:12:1",
        "    |",
        " 12 | use c",
        "    | --- and there",
        "    |",
        "    = note: so",
    ]


def test_a_fix_of_several_edits_is_shown_as_the_lines_that_it_changes() -> None:
    fix = Fix(at(3, 5, 1), "go", also=(Edit(at(1, 10, 0), "(x: T)"),), certain=True)
    lines = picture(Diagnostic("E104", "nothing", at(3, 5, 1), fix=fix), a="program f:\n    #\n    g()\n")
    assert lines[-5:] == [
        "   = fix: `ntp check --fix` would write",
        " 1 - program f:",
        " 1 + program f(x: T):",
        " 3 -     g()",
        " 3 +     go()",
    ]


def test_an_offer_says_that_it_is_left_to_the_user() -> None:
    mistake = Diagnostic("E104", "nothing", at(1, 1, 1), fix=Fix(at(1, 1, 1), "go"))
    assert "   = offer: perhaps this is meant; `ntp check --fix` leaves it to you" in picture(
        mistake, a="g\n"
    )


def test_a_fix_that_the_message_names_is_not_shown_again() -> None:
    mistake = Diagnostic("E1", "did you mean 'on'?", at(1, 1, 1), fix=Fix(at(1, 1, 1), "on"))
    assert not any("fix" in line for line in picture(mistake, a="o\n"))


@pytest.mark.parametrize(
    "row, column, caret",
    [
        ("\tx y", 4, "\t  ^"),
        ('"""日本""" y', 10, "           ^"),
        ('"""e\u0301""" y', 10, "        ^"),
        ("y", 2, " ^"),
        ("\x1b[31my", 6, "     ^"),
    ],
)  # fmt: skip
def test_the_caret_is_below_its_character(row: str, column: int, caret: str) -> None:
    lines = picture(Diagnostic("E001", "here", at(1, column, 1)), a=row)
    assert lines[-1] == f"   | {caret}" and "\x1b" not in lines[-2]


def test_a_diagnostic_without_a_text_or_a_place_is_shown_too() -> None:
    assert picture(Diagnostic("N001", "so", at(9, 1, 1))) == ["note[N001]: so", "  --> a.ntp:9:1"]
    assert picture(Diagnostic("N001", "so", at(9, 1, 1)), a="x\n")[:2] == [
        "note[N001]: so", "  --> a.ntp:9:1",
    ]  # fmt: skip


def test_only_lines_that_differ_are_changes() -> None:
    assert list(changed_lines("a\nb\nc\nd", "a\nB\nc\nx\nd")) == [
        (2, "-", "b"), (2, "+", "B"), (4, "+", "x"),
    ]  # fmt: skip
    assert list(changed_lines("a\na", "a")) == [(2, "-", "a")]


def test_every_code_belongs_to_a_family() -> None:
    assert {code[1] for code in CODES} <= set(FAMILIES)
