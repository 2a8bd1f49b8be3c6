"""The check of scenes: sound ones with stacks pass; one that cannot be made is an error at its group."""

from __future__ import annotations

from pathlib import Path

import pytest
from checked_libraries import diagnostics, excerpt

from ntp_dsl.language.diagnostics.diagnostics import Diagnostic
from ntp_dsl.language.loader import diagnose

LIBRARY = """library mine
use containers

type Pad is Place
type Stone is Place
type Low is Movable
type High is Movable

{declarations}

program fill(goal: list[Placement]):
    achieves all on(p.item, p.support) for p in goal
    for p in goal:
        pick_and_place(p.item, p.support)

task filling:
    scene: {scene}
    goal:    {goal}
    run:     fill(goal)
    success: all on(p.item, p.support) for p in goal
"""
PADS = """
        pads: 3 Pad on table with box(9 cm, 9 cm, 1 cm)"""
STACK = """
        lows: 3 Low on table"""
TOWER = "towers(lows, placements=1..1, height=2)"
SOME = "permutations(lows, pads, length=1..2)"
SOUND = {
    "two lows on three pads": (PADS + "\n        lows: 2 Low on pads", SOME),
    "two highs on two lows": (PADS + "\n        lows: 2 Low on pads\n        highs: 2 High on lows", SOME),
    "highs that leave their lows": (
        PADS + "\n        lows: 2 Low on table\n        highs: 2 High on lows",
        "matchings(highs, pads, pairs=1..2, each=1)",
    ),
    "lows that change their pads": (
        PADS.replace("3 Pad", "4 Pad") + "\n        lows: 3 Low on pads",
        "permutations(lows, pads, length=1..1)",
    ),
    "two groups that share three pads": (
        PADS + "\n        lows: 2 Low on pads\n        highs: 1 High on pads",
        "towers(lows, placements=1..1, height=2)",
    ),
    "a group that may be empty": (
        STACK + "\n        highs: 0..1 High on table",
        "towers(lows, highs, placements=1..1, height=2)",
    ),
    "two fixed stones as close as they are told": (
        STACK + "\n        stones: 2 Stone on table with cube(4 cm), at(40 cm, 0 cm, 45 cm, 0 cm)",
        TOWER,
    ),
    "movable objects as close as they are told": (
        "\n        lows: 3 Low on table with at(40 cm, 0 cm, 46 cm, 0 cm, 52 cm, 0 cm)",
        TOWER,
    ),
    "objects side by side in a bin": (
        "\n        docks: 4 Stone on table"
        "\n        pads: 1 Pad on table with bin(21 cm, 21 cm, 8 cm), at(40 cm, 38 cm)"
        "\n        lows: 4 Low on pads",
        "permutations(lows, docks, length=1..2)",
    ),
}
IMPOSSIBLE = {
    # what: scene, code, excerpt at its place, and message
    "four blocks on two docks": (
        STACK + "\n        docks: 2 Stone on table\n        highs: 4 High on docks",
        "highs: 4 High on docks",
        "of 'highs' both start on stone_",
    ),
    "five parcels on four docks, sometimes": (
        STACK + "\n        docks: 4 Stone on table\n        highs: 2..5 High on docks",
        "highs: 2..5 High on docks",
        "which has room for one",
    ),
    "an overfull bin": (
        STACK
        + "\n        bins: 1 Stone on table with bin(13 cm, 13 cm, 8 cm)\n        highs: 5 High on bins",
        "highs: 5 High on bins",
        "do not fit on stone_0",
    ),
    "the second group has no room": (
        STACK + "\n        highs: 9 High on table with cube(7 cm), x(0.4 .. 0.5 m), y(-0.1 .. 0.1 m)",
        "highs: 9 High on table with cube(7 cm), x(0.4 .. 0.5 m), y(-0.1 .. 0.1 m)",
        "high_0, high_1, high_2, high_3, ... do not fit where they are to start",
    ),
    "two stones inside each other": (
        STACK + "\n        stones: 2 Stone on table with cube(4 cm), at(40 cm, 0 cm, 43 cm, 0 cm)",
        "stones: 2 Stone on table with cube(4 cm), at(40 cm, 0 cm, 43 cm, 0 cm)",
        "inside each other: stone_0 (4 x 4 cm) at x 40 cm, y 0 cm and stone_1 (4 x 4 cm) at x 43 cm",
    ),
    "a bowl in a bin that is hardly wider": (
        STACK
        + "\n        bins: 1 Stone on table with bin(20 cm, 20 cm, 8 cm)"
        + "\n        highs: 1 High on bins with bowl(19.5 cm, 6 cm)",
        "highs: 1 High on bins with bowl(19.5 cm, 6 cm)",
        "high_0 would sink into stone_0",
    ),
    "an object that would be a table": (
        STACK + "\n        highs: 1 High on table with cube(90 cm)",
        "highs: 1 High on table with cube(90 cm)",
        "80 cm is the most",
    ),
}
REFUSED = {
    # what: declarations, scene, code, excerpt at its place, and message
    "a group called goal": (
        "",
        "\n        goal: 3 Low on table",
        "E305",
        "goal",
        "'goal' is the task's goal",
    ),
    "a group of objects called like a constant": (
        "constant low_1: Place",
        STACK,
        "E305",
        "lows",
        "'low_1' is a constant",
    ),
    "a lone group that may be empty": ("", "\n        lows: 0..1 Low on table", "E502", "", "nothing to do"),
    "objects on a group that may be empty": (
        "",
        STACK + "\n        stones: 0..1 Stone on table\n        highs: 1 High on stones",
        "E502",
        "stones",
        "which may be empty",
    ),
}
MISDECLARED = {
    "an api without the argument that its skill takes": (
        "api fetch() by grasp\n    achieves not empty(gripper)\n\n"
        "program get():\n    achieves not empty(gripper)\n    fetch()",
        "api 'fetch' has 0 parameters, and 'grasp', by which it is provided, takes target",
    ),
    "a predicate of too few": (
        "predicate lone(x: Object) by on\n\nprogram get(x: Low):\n    requires present(x) and reachable(x)\n"
        "    achieves lone(x)\n    pick(x)",
        "predicate 'lone' has 1 parameters, and 'on', by which it is provided, takes item, support",
    ),
    "a reading by what is true or false": (
        "enum Side: left, right\npredicate side(x: Object) -> Side by clear\n\n"
        "program get(x: Low):\n    requires present(x) and reachable(x)\n    "
        "achieves side(x) == left\n    pick(x)",
        "predicate 'side' is a reading, and 'clear' is true or false",
    ),
}


def written(folder: Path, scene: str, goal: str = TOWER, declarations: str = "") -> Path:
    path = folder / "mine.ntp"
    path.write_text(LIBRARY.format(scene=scene, goal=goal, declarations=declarations))
    return path


def errors(found: list[Diagnostic]) -> list[Diagnostic]:
    return [each for each in found if each.severity == "error"]


@pytest.mark.parametrize("library", SOUND)
def test_a_sound_library_with_stacks_is_not_refused(tmp_path: Path, library: str) -> None:
    found = diagnostics(written(tmp_path, *SOUND[library]))
    assert {each.code for each in found} <= {"W602"}, "part of a drawn goal may hold already"


@pytest.mark.parametrize("scene", IMPOSSIBLE)
def test_a_scene_that_cannot_be_made_names_the_group(tmp_path: Path, scene: str) -> None:
    declared, place, message = IMPOSSIBLE[scene]
    path = written(tmp_path, declared)
    (error,) = errors(diagnostics(path))
    assert error.code == "E608" and message in error.message
    assert excerpt(path, error) == place


@pytest.mark.parametrize("scene", REFUSED)
def test_a_scene_that_means_nothing_is_refused_by_the_static_check(tmp_path: Path, scene: str) -> None:
    declarations, declared, code, place, message = REFUSED[scene]
    path = written(
        tmp_path, declared, TOWER.replace("lows", "goal" if "goal:" in declared else "lows"), declarations
    )
    found = errors(list(diagnose(path).diagnostics))
    error = next(each for each in found if message in each.message)
    assert error.code == code and (not place or excerpt(path, error) == place)


@pytest.mark.parametrize(
    "declarations",
    [
        "api seize(it: Table) by grasp\n    achieves not empty(gripper)\n\n"
        "program get():\n    achieves not empty(gripper)\n    seize(table)",
        "predicate deep(it: Gripper) by hollow\n\nprogram get(x: Low):\n"
        "    requires present(x) and reachable(x)\n    achieves deep(gripper)\n    pick(x)",
        "predicate weight(it: Gripper) -> mass\n\nprogram get(x: Low):\n"
        "    requires present(x) and reachable(x)\n    achieves weight(gripper) > 1 kg\n    pick(x)",
    ],
)
def test_what_no_object_can_be_asked_is_a_finding_and_no_crash(tmp_path: Path, declarations: str) -> None:
    assert {each.code for each in diagnostics(written(tmp_path, STACK, declarations=declarations))} <= {
        "E601",
        "E607",
        "W605",
    }


def test_the_smallest_objects_can_be_tested(tmp_path: Path) -> None:
    diagnostics(written(tmp_path, STACK + " with cube(0.1 cm)"))


@pytest.mark.parametrize("case", MISDECLARED)
def test_what_a_provider_does_not_match_is_an_error_at_its_declaration(tmp_path: Path, case: str) -> None:
    declarations, message = MISDECLARED[case]
    (error,) = errors(diagnostics(written(tmp_path, STACK, declarations=declarations)))
    assert (error.code, error.message) == ("E112", message)
