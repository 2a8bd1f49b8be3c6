"""Objects of other proportions than cubes: on their sides, on rims, on the roll, and several on one tray."""

from __future__ import annotations

from itertools import combinations, permutations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from kinematics.geometry.transforms import quaternion_from_rotation, rotation_about
from kinematics.shapes.bodies import Body
from kinematics.shapes.shapes import Cylinder
from kinematics.simulation.bullet_cell import BulletCell
from ntp_dsl.language.loader import load
from ntp_dsl.semantics import predicates
from ntp_dsl.semantics.geometry import Vector, extents_as_it_lies, orientation_with_extents
from ntp_dsl.semantics.observation import Observation, SceneObject
from ntp_dsl.tasks.instances import draw, find_task
from ntp_dsl.user_code.loading import load_with_python
from ntp_dsl.worlds.catalogue import make_world
from ntp_dsl.worlds.protocol import Scene

TABLE = SceneObject("table", "Table", (1.5, 1.5, 0.04))
UNDER: Vector = (0.5, 0.0, -0.02)
BRICK = SceneObject("brick", "Movable", (0.03, 0.05, 0.08))
SQUARE = [np.array(rows) for rows in permutations(np.eye(3)) if np.linalg.det(rows) > 0]


@given(
    turned=st.sampled_from(SQUARE),
    axis=st.tuples(*3 * [st.floats(-1, 1)]).filter(lambda axis: np.linalg.norm(axis) > 0.1),
    angle=st.floats(-0.5, 0.5),
)
def test_how_a_object_lies_is_told_to_the_nearest_quarter_turn(
    turned: np.ndarray, axis: Vector, angle: float
) -> None:
    leaning = rotation_about(np.array(axis) / np.linalg.norm(axis), angle) @ turned
    turn = quaternion_from_rotation(leaning)
    assert extents_as_it_lies(BRICK.size, turn)[2] == pytest.approx(np.abs(turned @ BRICK.size)[2])
    if turned[2, 2] == 0:
        assert extents_as_it_lies(BRICK.size, turn) == pytest.approx(np.abs(turned @ BRICK.size))


@pytest.mark.parametrize("size", sorted(set(permutations(BRICK.size))))
def test_a_object_is_on_another_whatever_side_it_lies_on(size: Vector) -> None:
    pad = SceneObject("pad", "Place", (0.05, 0.05, 0.01), fixed=True)
    positions = {"table": UNDER, "pad": (0.5, 0.0, 0.005), "brick": (0.5, 0.0, 0.01 + size[2] / 2)}
    objects = (TABLE, pad, BRICK)
    turns = {"brick": orientation_with_extents(BRICK.size, size)}
    seen = Observation(objects, positions, (0.5, 0.2, 0.4), False, orientations=turns)
    assert predicates.on(seen, "brick", "pad") and not predicates.clear(seen, "pad")
    as_if_upright = Observation(objects, positions, (0.5, 0.2, 0.4), False)
    assert predicates.on(as_if_upright, "brick", "pad") == (abs(size[2] - BRICK.size[2]) < 0.02)


def test_what_rolls_comes_to_rest() -> None:
    lying = (np.sqrt(0.5), 0.0, 0.0, np.sqrt(0.5))
    with BulletCell() as cell:
        for way in ((1.0, 0.0), (-1.0, 0.0)):
            cell.reset([Body("can", Cylinder(0.024, 0.06), (0.5, 0.0, 0.024), lying, mass=0.1)], 0)
            cell.push("can", 0.03, way)  # 0.3 m/s
            cell.settle(3.0)
            before = cell.pose("can").position
            cell.settle(2.0)
            assert 0.02 < abs(before[0] - 0.5) < 0.3
            assert np.allclose(cell.pose("can").position, before, atol=1e-3)


@pytest.mark.parametrize("world", ["kinematic", "bullet", "mujoco"])
@pytest.mark.parametrize("width, falls_in", [(0.072, False), (0.03, True)])
def test_a_lid_rests_on_the_rim_and_what_is_narrower_falls_in(
    world: str, width: float, falls_in: bool
) -> None:
    bowl = SceneObject("bowl", "Movable", (0.07, 0.07, 0.05), "bowl")
    lid = SceneObject("lid", "Movable", (width, width, 0.02), "cylinder")
    positions = {"table": UNDER, "bowl": (0.5, 0.1, 0.025), "lid": (0.45, -0.1, 0.01)}
    made = make_world(world, load("table_cleanup"))
    made.reset(Scene((TABLE, bowl, lid), positions), seed=0)
    calls = (("move_to", ("lid",)), ("grasp", ("lid",)), ("move_to", ("bowl",)), ("release", ()))
    for api, arguments in calls:
        outcome = made.call(api, arguments)
        assert outcome.achieved, (api, outcome)
    made.settle(1.0)
    seen = made.truth()
    assert predicates.inside(seen, "lid", "bowl") == falls_in
    assert predicates.on(seen, "lid", "bowl") != falls_in


@pytest.mark.parametrize("world", ["kinematic", "bullet", "mujoco"])
def test_two_bowls_find_room_on_a_tray_that_has_it(world: str) -> None:
    tray = SceneObject("tray", "Place", (0.3, 0.26, 0.01), fixed=True)
    bowls = tuple(SceneObject(f"bowl_{n}", "Movable", (0.11, 0.11, 0.05), "bowl") for n in range(2))
    positions = {"table": UNDER, "tray": (0.52, 0.2, 0.005)}
    positions |= {"bowl_0": (0.45, -0.2, 0.025), "bowl_1": (0.6, -0.1, 0.025)}
    made = make_world(world, load("table_cleanup"))
    made.reset(Scene((TABLE, tray, *bowls), positions), seed=0)
    for bowl in ("bowl_0", "bowl_1"):
        for api, arguments in (
            ("move_to", (bowl,)),
            ("grasp", (bowl,)),
            ("move_to", ("tray",)),
            ("release", ()),
        ):
            assert made.call(api, arguments).achieved
        assert predicates.on(made.truth(), bowl, "tray")


def test_a_wide_object_is_over_a_bin_whatever_is_in_there() -> None:
    crate = SceneObject("bin", "Place", (0.2, 0.2, 0.1), "bin", fixed=True)
    bar, cube = SceneObject("bar", "Movable", (0.32, 0.05, 0.05)), SceneObject("cube", "Movable", (0.05,) * 3)
    positions = {"table": UNDER, "bin": (0.5, 0.25, 0.05), "cube": (0.5, 0.25, 0.03), "bar": (0.5, 0.0, 0.4)}
    made = make_world("kinematic", load("table_cleanup"), exact=True)
    scene = Scene((TABLE, crate, bar, cube), positions, gripper=(0.5, 0.0, 0.4), held="bar")
    made.reset(scene, seed=0)
    assert made.call("move_to", ("bin",)).achieved
    assert predicates.above(made.truth(), "gripper", "bin")
    assert made.call("release", ()).achieved
    assert not predicates.inside(made.truth(), "bar", "bin")


def test_no_two_bowls_start_in_each_other() -> None:
    registry = load_with_python("table_cleanup")
    task = find_task(registry, "four_and_twenty")
    for seed in range(60):
        rng = np.random.default_rng(seed)
        scene = draw(registry, task, rng).perturbed_start(rng)
        bowls = [n for n, obj in scene.by_name.items() if obj.cavity is not None and n != scene.held]
        for a, b in combinations(bowls, 2):
            (ax, ay, az), (bx, by, bz) = scene.positions[a], scene.positions[b]
            assert abs(az - bz) > 0.045 or max(abs(ax - bx), abs(ay - by)) > 0.14, (seed, a, b)
