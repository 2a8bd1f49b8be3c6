"""Objects beside others and at angles: what the relations say, and what the skills bring about."""

from __future__ import annotations

from dataclasses import replace
from math import pi, radians
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from kinematics.shapes.bodies import PLAIN_FRICTION
from ntp_dsl.core.one_core import load_one_core, shipped_core
from ntp_dsl.core.perception.perceived import Perceived
from ntp_dsl.datasets.recording import demonstration_start
from ntp_dsl.evaluation.episode_parts import starting_scene
from ntp_dsl.evaluation.episodes import Evaluator, Plan, run_all
from ntp_dsl.execution.refusals import differ
from ntp_dsl.language.diagnostics.diagnostics import NtpError
from ntp_dsl.language.loader import diagnose_text, load, load_text
from ntp_dsl.semantics.facts import Literal
from ntp_dsl.semantics.geometry import CLEARLY, about_vertical, extents_as_it_lies, turned_by
from ntp_dsl.semantics.layout import (
    SIDES,
    aligned,
    angle_between_lines,
    beside,
    places_beside,
    room_beside,
    turned,
    yaw,
)
from ntp_dsl.semantics.observation import Observation, SceneObject
from ntp_dsl.semantics.state import State
from ntp_dsl.tasks.instances import draw, find_task
from ntp_dsl.worlds.arm_bodies import bodies_of
from ntp_dsl.worlds.catalogue import make_world
from ntp_dsl.worlds.protocol import Failure, Outcome, Scene, World
from ntp_dsl.worlds.scenes import NoRoom

ANGLES = st.floats(-pi, pi)
TABLE = SceneObject("table", "Table", (1.5, 1.5, 0.04))
ROD = SceneObject("rod", "Movable", (0.12, 0.02, 0.02))
MUG = SceneObject("mug", "Movable", (0.06, 0.06, 0.08), "cylinder")
PLATE = SceneObject("plate", "Place", (0.08, 0.08, 0.02), "cylinder", fixed=True)
PLACES = {
    "table": (0.5, 0.0, -0.02),
    "rod": (0.35, -0.15, 0.01),
    "mug": (0.65, 0.15, 0.04),
    "plate": (0.5, 0.0, 0.01),
}
SCENE = Scene((ROD, MUG, PLATE, TABLE), PLACES, {"rod": 0.3})
TASK = """library l
use layout

program p(a: Movable):
    requires present(a) and reachable(a)
    achieves turned(a, 0)
    pick(a)
    turn_held(a, 0)

task t:
    scene:
        red: Movable on table with box(10 cm, 3 cm, 3 cm), {red}
    run:     p(red)
    success: turned(red, 0)
"""


def seen(mug: tuple[float, float, float]) -> Observation:
    return Observation((MUG, PLATE, TABLE), {**PLACES, "mug": mug}, (0.3, 0.0, 0.4), False)


@given(ANGLES, ANGLES)
def test_a_turn_adds_to_the_yaw_of_an_object(first: float, second: float) -> None:
    assert angle_between_lines(
        yaw(turned_by(about_vertical(first), second)), first + second
    ) == pytest.approx(0, abs=1e-6)


@given(ANGLES, st.floats(-1.4, 1.4))
def test_half_a_turn_makes_no_difference_to_an_angle(angle: float, off: float) -> None:
    turns = {"rod": about_vertical(angle)}
    state = Observation((ROD, TABLE), PLACES, (0.3, 0.0, 0.4), False, orientations=turns)
    assert turned(state, "rod", angle + off) == turned(state, "rod", angle + off + pi)
    assert turned(state, "rod", angle) and turned(state, "rod", angle + off) == (abs(off) < radians(5))


@given(ANGLES)
def test_objects_that_are_parallel_stay_so_when_both_are_turned(angle: float) -> None:
    turns = {"rod": about_vertical(angle), "mug": about_vertical(angle + 0.05)}
    state = Observation((ROD, MUG, TABLE), PLACES, (0.3, 0.0, 0.4), False, orientations=turns)
    assert aligned(state, "rod", "mug") and aligned(state, "mug", "rod")
    assert not aligned(state, "rod", "rod")


@given(st.floats(-0.25, 0.25), st.floats(-0.25, 0.25))
def test_what_is_left_of_something_is_right_of_it_in_a_mirror(dx: float, dy: float) -> None:
    here, mirrored = seen((0.5 + dx, dy, 0.04)), seen((0.5 + dx, -dy, 0.04))
    assert beside(here, "mug", "plate", "left") == beside(mirrored, "mug", "plate", "right")
    assert sum(beside(here, "mug", "plate", side) for side in SIDES) <= 1
    assert beside(here, "mug", "plate", "front") == beside(mirrored, "mug", "plate", "front")


def test_beside_means_near_and_at_the_same_height() -> None:
    assert beside(seen((0.5, 0.11, 0.04)), "mug", "plate", "left")
    assert not beside(seen((0.5, 0.25, 0.04)), "mug", "plate", "left")  # too far away
    assert not beside(seen((0.5, 0.11, 0.09)), "mug", "plate", "left")  # on something
    assert not beside(seen((0.5, 0.05, 0.04)), "mug", "plate", "left")  # partly over it
    assert beside(seen((0.61, 0.0, 0.04)), "mug", "plate", "behind")


def test_there_is_no_room_where_something_else_stands() -> None:
    state = seen((0.7, 0.2, 0.04))
    assert all(room_beside(state, "mug", "plate", side) for side in SIDES)
    wall = SceneObject("wall", "Place", (0.3, 0.1, 0.1), fixed=True)
    walled = replace(
        state, objects=(*state.objects, wall), positions={**state.positions, "wall": (0.5, 0.12, 0.05)}
    )
    assert not room_beside(walled, "mug", "plate", "left") and room_beside(walled, "mug", "plate", "right")
    assert not room_beside(state, "mug", "mug", "left")


@pytest.mark.parametrize("world", ["kinematic", "bullet", "mujoco"])
@pytest.mark.parametrize("side", SIDES)
def test_what_is_put_down_at_a_side_lies_there(world: str, side: str) -> None:
    there = make_world(world, load("layout"))
    there.reset(SCENE, 0)
    for api, arguments in (
        ("move_to", ("mug",)),
        ("grasp", ("mug",)),
        ("move_beside", ("mug", "plate", side)),
        ("release", ()),
    ):
        if api == "release":
            assert State(load("layout"), there.truth()).holds(Literal("over_side", ("mug", "plate", side)))
        assert there.call(api, arguments)
    assert beside(there.truth(), "mug", "plate", side)
    others = [other for other in SIDES if other != side]
    assert not any(beside(there.truth(), "mug", "plate", other) for other in others)


@pytest.mark.parametrize("world", ["kinematic", "bullet", "mujoco"])
@pytest.mark.parametrize("degrees", [-80, -35, 10, 55, 90])
def test_what_is_held_is_turned_where_it_is_and_stays_so_when_it_is_put_down(
    world: str, degrees: int
) -> None:
    there = make_world(world, load("layout"))
    there.reset(SCENE, 0)
    assert there.call("move_to", ("rod",)) and there.call("grasp", ("rod",))
    before = there.truth().positions["rod"]
    assert there.call("turn_held", ("rod", radians(degrees)))
    assert np.allclose(there.truth().positions["rod"], before, atol=0.006)
    assert there.call("release", ())
    assert turned(there.truth(), "rod", radians(degrees))


def refused(world: World, api: str, *arguments: str | float) -> Outcome:
    outcome = world.call(api, arguments)
    assert not outcome
    return outcome


@pytest.mark.parametrize("world", ["kinematic", "bullet", "mujoco"])
def test_skills_that_cannot_be_carried_out_say_why(world: str) -> None:
    there = make_world(world, load("layout"))
    there.reset(SCENE, 0)
    assert refused(there, "turn_held", "rod", 1.0).evidence == {"in hand": "nothing"}
    assert refused(there, "move_beside", "mug", "plate", "left").failure is Failure.NOT_READY
    assert there.call("move_to", ("mug",)) and there.call("grasp", ("mug",))
    assert refused(there, "align_held", "rod", "plate").evidence == {"in hand": "mug"}
    assert refused(there, "align_held", "mug", "spoon").failure is Failure.MISSING_OBJECT
    assert refused(there, "move_beside", "mug", "spoon", "left").failure is Failure.MISSING_OBJECT


def test_a_place_that_is_offered_is_one_where_the_relation_holds() -> None:
    state = seen((0.7, 0.2, 0.04))
    for side in SIDES:
        for x, y in places_beside(state, "mug", "plate", side):
            assert beside(seen((x, y, 0.04)), "mug", "plate", side)


def test_the_core_is_as_sure_of_a_relation_as_the_noise_allows() -> None:
    registry, network = load("layout"), load_one_core(shipped_core()).grounding
    chances = []
    for y in (0.11, 0.071, 0.045):  # well beside the plate, at its edge, and over it
        noisy = replace(seen((0.5, y, 0.04)), deviations={"mug": 0.004, "plate": 0.004})
        state = Perceived(registry, noisy, network)
        fact = Literal("beside", ("mug", "plate", "left"))
        chances.append(sum(chance for chance, variant in state.variants([fact]) if variant.holds(fact)))
    assert chances[0] == 1 and 0.2 < chances[1] < 0.9 and chances[2] < 0.05


@pytest.mark.parametrize("low, high", [(30, 30), (-120, -100)])
def test_a_scene_says_how_its_objects_are_turned(tmp_path: Path, low: int, high: int) -> None:
    path = tmp_path / "l.ntp"
    path.write_text(TASK.format(red=f"yaw({low} .. {high} deg)" if low != high else f"yaw({low} deg)"))
    registry = load(path)
    for seed in range(5):
        rng = np.random.default_rng(seed)
        scene = draw(registry, find_task(registry, "t"), rng).nominal_start(rng)
        assert radians(low) <= scene.yaws["red"] <= radians(high)


def test_a_yaw_that_is_none_is_explained() -> None:
    for setting, told in (("yaw(3 cm)", "takes an angle"), ("yaw(90 .. 30 deg)", "ends below its start")):
        found = diagnose_text(TASK.format(red=setting)).diagnostics
        assert any(told in each.message for each in found), (setting, found)


def test_mass_and_friction_of_a_scene_are_those_of_the_simulated_bodies() -> None:
    heavy = replace(MUG, traits=(("mass", 0.7), ("friction", 0.4)))
    mug, plate = bodies_of(Scene((heavy, PLATE), PLACES))
    assert (mug.mass, mug.friction) == (0.7, 0.4)
    assert (plate.mass, plate.friction) == (0.0, PLAIN_FRICTION)


MUGS = """library l
use layout

type Mug is Movable
type Plate is Place
record Beside(mug: Mug, plate: Plate, side: Side)

program set_mugs(goal: list[Beside]):
    achieves all beside(g.mug, g.plate, g.side) for g in goal
    for g in goal: put_beside(g.mug, g.plate, g.side)

task by_name:
    scene:
        plate: Plate on table with {plate}
        a: Mug on table with {mug}
        b: Mug on table
    goal: (a, plate, {side})
    run: set_mugs(goal)
    success: beside(a, plate, {side})
"""


def library_with(folder: Path, plate: str, mug: str = "cube(5 cm)", side: str = "left") -> Path:
    path = folder / "l.ntp"
    path.write_text(MUGS.format(plate=plate, mug=mug, side=side))
    return path


@pytest.mark.parametrize("seed", range(4))
def test_a_goal_judged_by_name_is_shown_from_where_it_does_not_hold(tmp_path: Path, seed: int) -> None:
    registry = load(library_with(tmp_path, "box(8 cm, 8 cm, 2 cm), at(50 cm, 0 cm)"))
    instance = draw(registry, find_task(registry, "by_name"), np.random.default_rng(seed))
    for number in range(20):
        scene = demonstration_start(registry, instance, 1000 * seed + number)
        assert not instance.holds_in(registry, scene)


@pytest.mark.parametrize("turn", [45, -45, 135, 90, 60])
def test_the_core_does_beside_turned_objects_what_an_expert_shows(tmp_path: Path, turn: int) -> None:
    plate = f"box(14 cm, 5 cm, 2 cm), at(50 cm, 0 cm), yaw({turn} deg)"
    path = library_with(tmp_path, plate, f"box(12 cm, 3 cm, 3 cm), yaw({-turn} deg)", "behind")
    for model in (None, shipped_core()):
        for episode in run_all(Plan(path, "by_name", model, seed=5), 3, workers=1):
            assert episode.success, episode.reason


@given(st.floats(-pi, pi), st.floats(-1e-6, 1e-6))
def test_extents_do_not_hang_on_how_an_orientation_is_rounded(angle: float, off: float) -> None:
    for near in (angle, pi / 4, -pi / 4, 3 * pi / 4):
        exact, rounded = about_vertical(near), tuple(map(float, np.float32(about_vertical(near + off))))
        if abs(abs(np.sin(near)) - abs(np.cos(near)) - CLEARLY) > 1e-4:
            assert extents_as_it_lies(ROD.size, exact) == extents_as_it_lies(ROD.size, rounded)


@pytest.mark.parametrize(
    "support, fits", [("bin(20 cm, 8 cm, 6 cm)", False), ("bin(8 cm, 20 cm, 6 cm)", True)]
)
def test_what_starts_turned_in_a_bin_has_room_for_its_length(
    tmp_path: Path, support: str, fits: bool
) -> None:
    text = MUGS.format(plate=support, mug="box(16 cm, 2 cm, 2 cm), yaw(90 deg)", side="left")
    path = tmp_path / "l.ntp"
    path.write_text(text.replace("a: Mug on table", "a: Mug on plate"))
    registry = load(path)
    rng = np.random.default_rng(0)
    instance = draw(registry, find_task(registry, "by_name"), rng)
    if fits:
        x, y, _ = instance.nominal_start(rng).positions["a"]
        assert np.isfinite([x, y]).all()
    else:
        with pytest.raises(NoRoom, match="do not fit on plate"):
            instance.nominal_start(rng)


def test_a_scene_in_which_a_given_goal_holds_is_drawn_again(tmp_path: Path) -> None:
    path = library_with(tmp_path, "box(20 cm, 5 cm, 2 cm), at(50 cm, 0 cm), yaw(90 deg)")
    evaluator, world = Evaluator(Plan(path, "by_name", None, seed=5)), make_world("kinematic", load(path))
    for number in range(30):
        scene = starting_scene(evaluator.registry, evaluator.instance(number), 5, number)
        world.reset(scene, 0)
        assert not beside(world.truth(), "a", "plate", "left")


def test_how_objects_are_turned_at_the_start_counts_when_it_is_judged_whether_a_goal_holds(
    tmp_path: Path,
) -> None:
    path = tmp_path / "l.ntp"
    path.write_text(TASK.format(red="yaw(30 deg)"))
    instance = Evaluator(Plan(path, "t", None, seed=5)).instance(0)
    rng = np.random.default_rng(0)
    assert not instance.holds_in(load(path), instance.nominal_start(rng))
    path.write_text(TASK.format(red="yaw(2 deg)"))
    assert instance.holds_in(load(path), draw(load(path), find_task(load(path), "t"), rng).nominal_start(rng))


@pytest.mark.parametrize(
    "detail, told",
    [
        ("yaw(30)", "30 rad is more than a turn"),
        ("mass(0 kg)", "the mass of an object is above zero"),
        ("friction(-1)", "the friction of an object is above zero"),
        ("weight(2 cm)", ""),
    ],
)
def test_what_no_object_can_be_is_explained(detail: str, told: str) -> None:
    readings = "predicate mass(o: Object) -> mass\npredicate friction(o: Object) -> number\n"
    readings += "predicate weight(o: Object) -> length\n"
    text = TASK.format(red=detail).replace("program p", f"{readings}\nprogram p")
    errors = [each.message for each in diagnose_text(text).diagnostics if each.code == "E504"]
    assert errors == ([told] if told else [])


def test_a_mass_that_is_measured_in_something_else_is_explained() -> None:
    text = TASK.format(red="mass(3 cm)").replace(
        "program p", "predicate mass(o: Object) -> length\n\nprogram p"
    )
    errors = [each.message for each in diagnose_text(text).diagnostics if each.code == "E504"]
    assert errors == ["'mass' is that of the simulated object, and a mass; this is a length"]


@pytest.mark.parametrize("first", ["table", "tray"])
def test_what_lies_on_a_low_tray_has_only_the_tray_beside_it(first: str) -> None:
    tray = SceneObject("tray", "Place", (0.2, 0.2, 0.01), fixed=True)
    surfaces = (TABLE, tray) if first == "table" else (tray, TABLE)
    places = {"table": (0.5, 0.0, -0.02), "tray": (0.5, 0.0, 0.005), "mug": (0.3, 0.2, 0.04)}
    cup = SceneObject("cup", "Movable", (0.05, 0.05, 0.06))
    state = Observation(
        (MUG, cup, *surfaces), {**places, "cup": (0.47, 0.0, 0.04)}, (0.3, 0.0, 0.4), closed=False
    )
    for side in SIDES:
        for x, y in places_beside(state, "mug", "cup", side):
            assert abs(x - 0.5) <= 0.07 and abs(y) <= 0.07


def test_a_turn_is_a_change_of_the_state() -> None:
    there = make_world("kinematic", load("layout"))
    there.reset(SCENE, 0)
    assert there.call("move_to", ("rod",)) and there.call("grasp", ("rod",))
    before = there.truth()
    assert there.call("turn_held", ("rod", 1.2)) and differ(before, there.truth())
    assert not differ(before, before)


@pytest.mark.parametrize(
    "details, told",
    [
        ("yaw(30 deg), bowl(12 cm, 5 cm)", "'bowl' and 'yaw' both say"),
        ("at(50 cm, 0 cm), offset(1 cm, 1 cm)", "'offset' and 'at' both say"),
        ("offset(1 cm, 1 cm), spacing(10 cm)", "'spacing' and 'offset' both say"),
    ],
)
def test_details_that_exclude_each_other_are_explained(details: str, told: str) -> None:
    text = TASK.replace("with box(10 cm, 3 cm, 3 cm), {red}", f"with {details}")
    assert any(told in each.message for each in diagnose_text(text).diagnostics)


def test_sides_of_another_enumeration_are_refused() -> None:
    text = "library l\nuse tabletop\nenum Way: north, south\n"
    text += "predicate beside(a: Object, b: Place, way: Way)\n"
    registry = load_text(text)
    with pytest.raises(NtpError, match="takes left, right, front, behind, and 'north' is none of these"):
        make_world("kinematic", registry)


def test_a_reading_of_the_scene_may_have_the_name_of_a_relation() -> None:
    registry = load_text("library l\nuse tabletop\npredicate turned(o: Object) -> angle\n")
    make_world("kinematic", registry)
