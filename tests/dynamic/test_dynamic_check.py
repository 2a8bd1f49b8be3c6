"""The dynamic check finds each planted fault at its location, and passes sound libraries."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
from checked_libraries import ALL_ON, PLACING, STACKING, diagnostics, excerpt, written

from ntp_dsl.common.resources import examples_folder, library_folder
from ntp_dsl.dynamic.check import check_dynamically
from ntp_dsl.dynamic.starts import STARTS, scene_text
from ntp_dsl.language.loader import find, load
from ntp_dsl.tasks.instances import draw, find_task
from ntp_dsl.user_code.loading import with_python
from ntp_dsl.worlds.catalogue import make_world

FOUND = {
    "E601 an api that does not ask for an empty hand": (
        """
api take(target: Object) by grasp
    requires above(gripper, target) and reachable(target)
    achieves holding(target)

program fill(goal: list[Placement]):
    achieves all on(p.item, p.support) for p in goal
    for p in goal:
        move(p.item, p.support)

program move(item: Object, support: Place):
    requires present(item) and reachable(item) and present(support) and reachable(support)
    achieves on(item, support)
    clear(item)
    clear(support)
    move_to(item)
    take(item)
    place(item, support)
"""
        + STACKING.format(run="fill(goal)", success=ALL_ON),
        "holding(target)",
    ),
    "E602 a goal that holds before anything is done": (
        PLACING + STACKING.format(run="fill(goal)", success="all present(p.item) for p in goal"),
        "all present(p.item) for p in goal",
    ),
    "E603 an expert that forgets half of the goal": (
        """
program fill(goal: list[Placement]):
    achieves all clear(p.support) for p in goal
    for p in goal:
        clear(p.support)
"""
        + STACKING.format(run="fill(goal)", success=ALL_ON),
        "fill(goal)",
    ),
    "E604 a success test that is content half-way": (
        PLACING + STACKING.format(run="fill(goal)", success="some not on(p.item, table) for p in goal"),
        "some not on(p.item, table) for p in goal",
    ),
    "E605 two objects that push each other off one pad": (
        """
type Pad is Place
"""
        + PLACING
        + """
task crowded:
    scene:
        pads: 2 Pad on table with box(7 cm, 7 cm, 1 cm)
        blocks: 5 Block on table
    goal:    matchings(blocks, pads, pairs=3)
    run:     fill(goal)
    success: all on(p.item, p.support) for p in goal
""",
        "pick_and_place(p.item, p.support)",
    ),
    "E608 a scene that does not fit on the table": (
        PLACING
        + STACKING.format(run="fill(goal)", success=ALL_ON).replace(
            "5 Block on table", "30 Block on table with cube(12 cm)"
        ),
        "blocks: 30 Block on table with cube(12 cm)",
    ),
}
FLAWED_PYTHON = {
    "E606": "random.sample(sorted(supports.items()), len(supports))",
    "E607": "supports.elements()",
}


@pytest.mark.parametrize("fault", FOUND)
def test_a_planted_fault_is_found_at_its_place(tmp_path: Path, fault: str) -> None:
    declarations, place = FOUND[fault]
    path = written(tmp_path, declarations)
    errors = [each for each in diagnostics(path) if each.severity == "error"]
    assert [each.code for each in errors] == [fault.split()[0]], errors
    assert excerpt(path, errors[0]) == place


def test_a_livelock_is_reported_as_a_cycle_of_source_lines(tmp_path: Path) -> None:
    path = written(tmp_path, FOUND["E605 two objects that push each other off one pad"][0])
    (livelock,) = [each for each in diagnostics(path) if each.code == "E605"]
    steps = [note.message for note in livelock.notes if note.message[0].isdigit()]
    assert [step.split(".")[0] for step in steps] == [str(number) for number in range(1, len(steps) + 1)]
    assert {"clear", "pick", "place"} <= {step.split()[1].split("(")[0] for step in steps}
    assert steps[-1].endswith("again, and so on")


def test_a_goal_that_is_not_reached_is_reported_with_the_start_and_without_a_seed(tmp_path: Path) -> None:
    (failed,) = diagnostics(written(tmp_path, FOUND["E603 an expert that forgets half of the goal"][0]))
    start = failed.notes[0].message
    assert start.startswith("it started (nominal) with all objects apart; the goal was (block_")
    assert "--seed" not in failed.help


def test_a_start_of_piles_is_described_object_by_object() -> None:
    registry = load("block_stacking")
    rng = np.random.default_rng(0)
    instance = draw(registry, find_task(registry, "block_stacking"), rng)
    world = make_world("kinematic", registry, exact=True)
    world.reset(STARTS["piles"][0](instance, rng), 0)
    text = scene_text(world.truth())
    assert text.count(" on block_") == 6 and "in the hand" not in text
    world.reset(STARTS["object in hand"][0](instance, rng), 0)
    assert scene_text(world.truth()).endswith(" in the hand")


def test_a_contract_violation_is_reported_with_positions_after_the_call(tmp_path: Path) -> None:
    (error,) = diagnostics(written(tmp_path, FOUND["E601 an api that does not ask for an empty hand"][0]))
    assert re.search(r"does not hold.*; afterwards: block_\d at \(0\.\d{3}, .*\) m$", error.notes[0].message)


LEANING = """
type Tray is Place

program deliver(goal: list[Placement]) by python:
    achieves all on(p.item, p.support) for p in goal
    calls bring

program bring(item: Movable, tray: Place):
    requires present(item) and reachable(item) and present(tray) and reachable(tray)
    achieves on(item, tray)
    uncover(item)
    pick_and_place(item, tray)

program uncover(item: Movable):
    requires present(item) and reachable(item)
    achieves clear(item)
    for b in Block if on(b, item):
        pick(b)

task delivering:
    scene:
        trays:  1 Tray on table with box(20 cm, 20 cm, 1 cm), at(50 cm, 38 cm)
        blocks: 5 Block on table
    goal:    matchings(blocks, trays, pairs=3)
    run:     deliver(goal)
    success: all on(p.item, p.support) for p in goal
"""


def test_off_centre_starts_find_that_a_python_expert_gets_stuck(tmp_path: Path) -> None:
    path = written(tmp_path, LEANING)
    path.with_suffix(".py").write_text(
        """
from ntp_dsl.authoring import call, expert, first

@expert
def deliver(world, goal):
    pairs = [(p["item"], p["support"]) for p in goal]
    return first(call("bring", *pair) for pair in pairs if not world.on(*pair))
"""
    )
    (stuck,) = check_dynamically(with_python(load(path)), path)
    assert stuck.code == "E603" and "(off-centre)" in stuck.message
    assert excerpt(path, stuck) == "deliver(goal)"
    path.write_text(path.read_text().replace("if on(b, item)", "if covers(b, item)"))
    assert check_dynamically(with_python(load(path)), path) == []


EXAMPLES = sorted(path.name for path in examples_folder().iterdir() if path.is_dir())


@pytest.mark.parametrize("example", EXAMPLES)
def test_an_example_passes(example: str) -> None:
    path = find(example)
    found = check_dynamically(with_python(load(path)), path)
    assert [str(each) for each in found if each.code != "N604"] == []  # of programs that several tasks share


def test_the_standard_library_keeps_its_contracts() -> None:
    path = library_folder() / "tabletop.ntp"
    assert [str(each) for each in diagnostics(path)] == []


DRAWER = """
type Drawer is Place
predicate opened(d: Drawer)
predicate opening(d: Drawer) -> length
api pull(d: Drawer, distance: length)
    requires above(gripper, d) and empty(gripper)
    achieves opened(d)

program open(d: Drawer):
    requires present(d) and reachable(d)
    achieves opened(d)
    put_down()
    move_to(d)
    pull(d, 0.25 - opening(d))
"""


def test_what_no_world_implements_is_noted_and_the_rest_is_tested(tmp_path: Path) -> None:
    goal_too_early = FOUND["E602 a goal that holds before anything is done"][0]
    path = written(tmp_path, DRAWER + goal_too_early)
    assert sorted(each.code for each in diagnostics(path)) == ["E602", "N602", "N602"]


def test_python_is_not_executed_unless_requested(tmp_path: Path) -> None:
    text = (examples_folder() / "blueprint" / "blueprint.ntp").read_text()
    path = tmp_path / "mine.ntp"
    path.write_text(text.replace("library blueprint", "library mine"))
    (tmp_path / "mine.py").write_text("raise SystemExit('imported')\n")
    notes = diagnostics(path)
    assert [each.code for each in notes] == ["N601", "N601"]
    assert "the expert 'build' is written in Python" in notes[0].message


@pytest.mark.parametrize("code", FLAWED_PYTHON)
def test_a_nondeterministic_or_failing_expert_in_python_is_found(tmp_path: Path, code: str) -> None:
    folder = examples_folder() / "blueprint"
    path = tmp_path / "mine.ntp"
    path.write_text((folder / "blueprint.ntp").read_text().replace("library blueprint", "library mine"))
    flawed = (folder / "blueprint.py").read_text().replace("sorted(supports.items())", FLAWED_PYTHON[code])
    (tmp_path / "mine.py").write_text(flawed.replace("from ntp_dsl", "import random\n\nfrom ntp_dsl", 1))
    errors = check_dynamically(with_python(load(path)), path)
    assert [each.code for each in errors] == [code]
    if code == "E607":
        assert "mine.py:" in errors[0].message and "has no attribute 'elements'" in errors[0].message


STONES = """
type Stone is Movable
enum Hue: red, blue
predicate weight_of(s: Stone) -> mass
predicate hue(s: Stone) -> Hue
program lighten(x: Place):
    requires present(x) and reachable(x)
    achieves all not on(s, x) for s in Stone if hue(s) == red and weight_of(s) > 0.5 kg
    for s in Stone if on(s, x) and hue(s) == red and weight_of(s) > 0.5 kg:
        pick(s)
"""
OTHER_STONES = """
program stack(goal: list[Placement]):
    achieves all on(p.item, p.support) for p in goal
    for p in goal:
        pick_and_place(p.item, p.support)
task stones:
    scene:   stones: 4 Stone on table with cube(4 cm), hue(red)
    goal:    towers(stones, placements=1..2, height=2..3)
    run:     stack(goal)
    success: all on(p.item, p.support) for p in goal
"""


@pytest.mark.parametrize("text", [STONES, STONES + OTHER_STONES], ids=["no task", "a task that says less"])
def test_readings_that_a_scene_leaves_out_are_not_reported(tmp_path: Path, text: str) -> None:
    (tmp_path / "a.ntp").write_text(f"library a\nuse tabletop\n{text}")
    assert [str(each) for each in diagnostics(tmp_path / "a.ntp")] == []


@pytest.mark.parametrize("text", ["library a\n", "library a\ntype Thing\ntype Tool is Thing\n"])
def test_a_library_without_objects_has_nothing_to_test(tmp_path: Path, text: str) -> None:
    (tmp_path / "a.ntp").write_text(text)
    assert diagnostics(tmp_path / "a.ntp") == []


def test_the_check_is_the_same_for_a_seed(tmp_path: Path) -> None:
    path = written(tmp_path, FOUND["E605 two objects that push each other off one pad"][0])
    assert diagnostics(path) == diagnostics(path)


WASHING = """
type Plate is Place
predicate washed(p: Plate) by state
predicate dried(p: Plate) by state
api wash(p: Plate)
    achieves washed(p)
api dry(p: Plate)
    achieves washed(p) and dried(p)
program clean(p: Plate):
    achieves washed(p) and dried(p)
{lines}
task cleaning:
    scene: plates: 2 Plate on table
    run: clean(plate_0)
    success: washed(plate_0) and dried(plate_0)
"""


@pytest.mark.parametrize(
    ("lines", "unused"), [("    wash(p)\n    dry(p)", []), ("    dry(p)\n    wash(p)", ["wash(p)"])]
)
def test_a_statement_that_no_trial_needs_is_told(tmp_path: Path, lines: str, unused: list[str]) -> None:
    path = written(tmp_path, WASHING.format(lines=lines))
    found = diagnostics(path)
    assert [excerpt(path, each) for each in found if each.code == "N604"] == unused
    assert not [each for each in found if each.severity == "error"]


def test_of_calls_that_undo_one_another_what_is_there_to_be_used_up_is_left_out(tmp_path: Path) -> None:
    lamps = """
type Lamp is Place
predicate lit(l: Lamp) by state
predicate left(l: Lamp) by state
predicate right(l: Lamp) by state
api light(l: Lamp)
    achieves lit(l)
api turn_left(l: Lamp)
    requires lit(l)
    achieves left(l) and not right(l) and not lit(l)
api turn_right(l: Lamp)
    requires lit(l)
    achieves right(l) and not left(l) and not lit(l)
program turn(l: Lamp):
    achieves left(l) and right(l)
    light(l)
    turn_left(l)
    light(l)
    turn_right(l)
task turning:
    scene: lamps: 1 Lamp on table
    run: turn(lamp_0)
    success: left(lamp_0) and right(lamp_0)
"""
    (livelock,) = [each for each in diagnostics(written(tmp_path, lamps)) if each.code == "E605"]
    (told,) = [note.message for note in livelock.notes if "ends that again" in note.message]
    assert "lit(" not in told and "turn_left" in told and "turn_right" in told
    assert livelock.help.endswith("or the goals contradict each other")


INSTALLING = """
type Lamp is Place
predicate wired(l: Lamp) by state
predicate switched(l: Lamp) by state
predicate tested(l: Lamp) by state
predicate lit(l: Lamp) by state
api wire(l: Lamp)
    achieves wired(l) and not tested(l)
api test(l: Lamp)
    achieves tested(l) and not wired(l)
api light(l: Lamp)
    requires switched(l)
    achieves lit(l)
api switch(l: Lamp)
    achieves switched(l)
program install(l: Lamp):
    achieves wired(l) and tested(l) and lit(l)
    when lit(l):
        switch(l)
    wire(l)
    light(l)
    test(l)
task installing:
    scene: lamps: 1 Lamp on table
    run: install(lamp_0)
    success: lit(lamp_0) and tested(lamp_0) and wired(lamp_0)
"""


def test_a_livelock_names_the_statement_that_starves(tmp_path: Path) -> None:
    path = written(tmp_path, INSTALLING)
    (livelock,) = [each for each in diagnostics(path) if each.code == "E605"]
    (starving,) = [each for each in livelock.notes if "which nothing before it provides" in each.message]
    assert starving.message.startswith("light(lamp_0) is needed, and lacks switched(lamp_0)")
    assert path.read_text().splitlines()[starving.span.line - 1].strip() == "light(l)"
    assert livelock.help.startswith("write a statement before 'light' that provides switched(lamp_0)")


def test_a_broken_promise_is_told_with_what_the_world_measured(tmp_path: Path) -> None:
    bricks = """
type Brick is Object
program set_down(b: Brick):
    requires present(b) and reachable(b)
    achieves on(b, table)
    pick_and_place(b, table)
task setting:
    scene: bricks: 2 Brick on table
    run: set_down(brick_0)
    success: on(brick_0, table)
"""
    found = diagnostics(written(tmp_path, bricks))
    notes = [note.message for each in found if each.code == "E601" for note in each.notes]
    assert any("(never moves: " in note for note in notes), notes
