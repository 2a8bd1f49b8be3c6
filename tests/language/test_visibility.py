"""A library sees its own names and those of all that it uses; clashes and unused names are reported."""

from __future__ import annotations

from pathlib import Path

import pytest

from ntp_dsl.common.resources import examples_folder, library_folder
from ntp_dsl.language.diagnostics.apply_fixes import apply_fixes
from ntp_dsl.language.diagnostics.diagnostics import Diagnostic, SourceError
from ntp_dsl.language.loader import Report, diagnose, load

CUPS = "library cups\nuse tabletop\ntype Cup is Movable\n"
STACK = """program stack(goal: list[Placement]):
    achieves all on(p.item, p.support) for p in goal
    for p in goal:
        pick_and_place(p.item, p.support)
task t:
    scene:   blocks: 8 Block on table
    goal:    towers(blocks, placements=1..6, height=2..4)
    run:     stack(goal)
    success: all on(p.item, p.support) for p in goal
"""


def diagnosed(folder: Path, text: str, **others: str) -> Report:
    for name, other in others.items():
        (folder / f"{name}.ntp").write_text(other)
    (folder / "a.ntp").write_text(text)
    return diagnose(folder / "a.ntp")


def only(report: Report) -> Diagnostic:
    (diagnostic,) = report.diagnostics
    return diagnostic


def fixed(folder: Path, report: Report) -> Report:
    """Return the report after the fixes are applied."""
    path = folder / "a.ntp"
    fixes = [each.fix for each in report.diagnostics if each.fix is not None]
    return diagnosed(folder, apply_fixes(path.read_text(), fixes, path))


def test_a_name_is_visible_through_used_libraries(tmp_path: Path) -> None:
    text = "library a\nuse cups\nprogram p(c: Cup):\n    achieves clear(c)\n    clear(c)\n"
    report = diagnosed(tmp_path, text, cups=CUPS)
    assert report.diagnostics == ()


def test_a_library_that_only_others_use_is_not_visible(tmp_path: Path) -> None:
    report = diagnosed(
        tmp_path,
        "library a\nuse cups\nuse trays\npredicate full(t: Tray, c: Cup)\n",
        cups=CUPS,
        trays="library trays\ntype Tray\npredicate holds(t: Tray, c: Cup)\n",
    )
    mistake = only(report)
    assert (mistake.code, mistake.span.line) == ("E103", 3) and mistake.span.path == tmp_path / "trays.ntp"
    assert "declared by library 'cups', which is not used here" in mistake.message
    assert mistake.fix is not None and mistake.fix.replacement == "use cups\n\n"


def test_a_forgotten_use_is_reported_once_and_fixed(tmp_path: Path) -> None:
    report = diagnosed(tmp_path, f"library a\n{STACK}")
    assert "library 'tabletop'" in only(report).message
    assert fixed(tmp_path, report).is_sound


def test_a_library_beside_is_offered_too(tmp_path: Path) -> None:
    report = diagnosed(tmp_path, "library a\nuse tabletop\nconstant mug: Cup\n", cups=CUPS)
    fix = only(report).fix
    assert fix is not None and not fix.certain  # it may be there for another purpose
    assert fixed(tmp_path, report).is_sound


def test_two_used_libraries_that_declare_one_name_clash_at_the_later(tmp_path: Path) -> None:
    report = diagnosed(
        tmp_path,
        "library a\nuse cups\nuse mugs\n",
        cups=CUPS,
        mugs="library mugs\nuse tabletop\ntype Cup is Movable\n",
    )
    mistake = only(report)
    assert (mistake.code, mistake.span.line) == ("E302", 3)
    assert [note.span.path and note.span.path.stem for note in mistake.notes] == ["cups", "mugs"]


def test_a_name_that_a_used_library_declares_too_is_reported_with_its_place(tmp_path: Path) -> None:
    mistake = only(diagnosed(tmp_path, "library a\nuse cups\ntype Cup\n", cups=CUPS))
    assert (mistake.code, mistake.span.line, mistake.span.column) == ("E302", 3, 6)
    assert (mistake.notes[0].span.line, mistake.notes[0].span.path) == (3, tmp_path / "cups.ntp")


def test_a_clash_within_used_libraries_is_reported_there_alone(tmp_path: Path) -> None:
    report = diagnosed(
        tmp_path, "library a\nuse b\n", b="library b\nuse cups\nuse mugs\n", cups=CUPS,
        mugs="library mugs\nuse tabletop\ntype Cup is Movable\n",
    )  # fmt: skip
    assert only(report).span.path == tmp_path / "b.ntp"


@pytest.mark.parametrize(
    ("text", "code", "place"),
    [
        ("library a\nuse tabletop\nuse tabletop\ntype Cup is Movable\n", "W301", (3, 5)),
        ("library a\nuse a\ntype Cup\n", "E304", (2, 5)),
        ("library a\nuse cups\ntype Mug\n", "W101", (2, 5)),
        ("library a\nuse Cups\ntype Mug is Cup\n", "E110", (2, 5)),
    ],
)
def test_a_wrong_use_is_reported_and_fixed(
    tmp_path: Path, text: str, code: str, place: tuple[int, int]
) -> None:
    report = diagnosed(tmp_path, text, cups=CUPS)
    mistake = only(report)
    assert (mistake.code, (mistake.span.line, mistake.span.column)) == (code, place)
    assert fixed(tmp_path, report).diagnostics == ()


def test_a_circle_is_reported_once_and_hides_nothing(tmp_path: Path) -> None:
    report = diagnosed(
        tmp_path, "library a\nuse b\ntype A is B\n", b="library b\nuse a\ntype B\npredicate p(x: A, y: C)\n"
    )
    assert [each.code for each in report.diagnostics] == ["E304", "E103"]


# Unused declarations; an `@` marks where the warning points.
IDLE = {
    "a parameter": ("W102", "program p(x: Object, @y: Object):\n    achieves clear(x)\n    clear(x)\n"),
    "a parameter of a composition": ("W102", "predicate p(x: Object, @y: Object): clear(x)\n"),
    "a loop's variable": ("W103", "program p(x: Object):\n    achieves clear(x)\n"
                          "    for @y in Object: clear(x)\n"),
    "a quantifier's variable": ("W103", "predicate p(x: Object): all clear(x) for @y in Object\n"),
    "a group": ("N104", "type Decoration is Place\n"
                + STACK.replace("   blocks: 8 Block on table", "   blocks: 8 Block on table, "
                                "@things: 2 Decoration on table")),
    "a goal": ("W105", STACK.replace("towers", "@towers").replace("stack(goal)\n", "tidy()\n")
               + "program tidy():\n    requires holding(any)\n    achieves empty(gripper)\n    put_down()\n"),
    "a program": ("N106", STACK + "program @p(x: Object):\n    achieves clear(x)\n    clear(x)\n"),
    "a composed predicate": ("N106", STACK + "predicate @free(x: Object): clear(x) and present(x)\n"),
    "an api": ("W106", STACK + "api @zap(x: Object)\n"),
    "a type": ("W106", STACK + "type @Cup is Movable\n"),
    "an enumeration": ("W106", STACK + "enum @Side: left, right\n"),
    "a constant": ("W106", STACK + "constant @shelf: Place\n"),
    "a predicate": ("W106", STACK + "predicate @hot(x: Object)\n"),
    "a record": ("W106", STACK + "record @Pair(x: Object)\n"),
}  # fmt: skip


@pytest.mark.parametrize("name", IDLE)
def test_an_unused_declaration_is_reported(name: str, tmp_path: Path) -> None:
    code, text = IDLE[name]
    before = f"library a\nuse tabletop\n{text[: text.index('@')]}"
    found = diagnosed(tmp_path, f"library a\nuse tabletop\n{text}".replace("@", ""))
    place = code, before.count("\n") + 1, len(before) - before.rfind("\n")
    assert place in [(each.code, each.span.line, each.span.column) for each in found.diagnostics]
    assert found.is_sound and {each.code for each in found.diagnostics} <= {code, "W106", "N106"}


def test_what_begins_with_an_underscore_is_meant_to_be_unused(tmp_path: Path) -> None:
    text = "program p(x: Object, _y: Object):\n    achieves clear(x)\n    clear(x)\ntype _Cup is Movable\n"
    plain = STACK.replace("stack(goal)", "stack(goal)")
    report = diagnosed(tmp_path, f"library a\nuse tabletop\n{plain}{text.replace(' p(', ' _p(')}")
    assert report.diagnostics == ()


def test_a_library_without_tasks_is_for_others(tmp_path: Path) -> None:
    report = diagnosed(tmp_path, "library a\nuse tabletop\nenum Side: left, right\napi zap(x: Object)\n")
    assert report.diagnostics == ()


@pytest.mark.parametrize(
    "path",
    sorted([*library_folder().glob("*.ntp"), *examples_folder().glob("*/*.ntp")]),
    ids=lambda path: path.stem,
)
def test_the_libraries_that_ship_raise_no_alarm(path: Path) -> None:
    assert diagnose(path).diagnostics == ()


def test_a_registry_is_named_after_the_library_that_was_asked_for(tmp_path: Path) -> None:
    diagnosed(tmp_path, "library a\nuse cups\ntype Mug is Cup\n", cups=CUPS)
    registry = load(tmp_path / "a.ntp")
    assert registry.name == "a" and registry.is_a("Mug", "Movable")
    diagnosed(tmp_path, "library a\nuse cups\ntype Mug is Cpu\n")
    with pytest.raises(SourceError, match="did you mean 'Cup'"):
        load(tmp_path / "a.ntp")
