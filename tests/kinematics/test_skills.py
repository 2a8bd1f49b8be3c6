"""The skills in the simulated cell: results, detected failures, and repeatability bit for bit."""

import math
import subprocess
import sys

import numpy as np
import pytest
from kinematics_scenes import HALF, cube, scattered

from kinematics.errors import Reason, UnusablePose
from kinematics.shapes.bodies import Body
from kinematics.shapes.catalogue import tub
from kinematics.shapes.shapes import Box
from kinematics.simulation.simulated_cell import SimulatedCell
from kinematics.skills.skills import Motion, grasp, move_above, move_above_free_place, release


def pick(cell: SimulatedCell, item: str, seed: int = 0) -> None:
    for motion in (move_above(cell, item, seed), grasp(cell, item, seed)):
        assert motion.achieved, motion
    assert cell.held() == item and cell.hand_closed


def pick_and_place(cell: SimulatedCell, item: str, support: str, seed: int = 0) -> None:
    pick(cell, item, seed)
    for motion in (move_above(cell, support, seed), release(cell, seed)):
        assert motion.achieved, motion


def apart(cell: SimulatedCell, a: str, b: str) -> float:
    first, second = cell.pose(a).position, cell.pose(b).position
    return math.hypot(first[0] - second[0], first[1] - second[1])


@pytest.mark.parametrize("seed", range(3))
def test_a_cube_is_placed_within_two_millimetres(cell: SimulatedCell, seed: int) -> None:
    cell.reset(scattered(seed), seed)
    pick_and_place(cell, "b0", "b1", seed)
    assert apart(cell, "b0", "b1") < 0.002
    assert cell.contacts("b0", "b1") and not cell.contacts("b0", "table")
    assert cell.held() is None and not cell.hand_closed


def test_the_tool_is_ten_centimetres_above_the_top(cell: SimulatedCell) -> None:
    cell.reset(scattered(4), 4)
    assert move_above(cell, "b2", seed=0).achieved
    x, y, z = cell.pose("b2").position
    assert np.allclose(cell.tool_position(), (x, y, z + HALF + 0.1), atol=2e-3)


def test_a_tower_of_four_stands(cell: SimulatedCell) -> None:
    cell.reset(scattered(1), 1)
    for i in range(3):
        pick_and_place(cell, f"b{i + 1}", f"b{i}")
    cell.settle(2.0)
    for i in range(3):
        assert apart(cell, f"b{i + 1}", f"b{i}") < 0.004
    assert cell.pose("b3").position[2] == pytest.approx(0.175, abs=2e-3)


def test_a_held_body_is_put_down_on_a_free_place(cell: SimulatedCell) -> None:
    cell.reset(scattered(2, count=10), 2)
    pick(cell, "b0")
    assert move_above_free_place(cell, seed=0).achieved and release(cell, seed=0).achieved
    assert cell.contacts("b0", "table")
    assert min(apart(cell, "b0", f"b{i}") for i in range(1, 10)) > 0.07


@pytest.mark.parametrize("slip_at", [0.1, 0.5, 0.95])
def test_a_slip_is_noticed_and_the_cube_is_picked_up_again(cell: SimulatedCell, slip_at: float) -> None:
    cell.reset(scattered(3), 3)
    pick(cell, "b0")
    motion = move_above(cell, "b1", seed=0, slip_at=slip_at)
    assert motion.reason is Reason.OBJECT_DROPPED
    assert motion.evidence["name"] == "b0" and motion.evidence["forced"]
    assert cell.held() is None and not cell.hand_closed
    pick(cell, "b0")


@pytest.mark.parametrize("tilt", [0.3, 0.6, math.pi / 4])
def test_a_leaning_cube_is_grasped_and_set_upright(cell: SimulatedCell, tilt: float) -> None:
    lean = Body(
        "lean", Box((HALF,) * 3), (0.5, 0.0, 0.06), (math.sin(tilt / 2), 0.0, 0.0, math.cos(tilt / 2))
    )
    cell.reset([lean, cube("prop", 0.5, 0.055), cube("far", 0.4, -0.15)], 0)
    pick_and_place(cell, "lean", "far")
    assert cell.pose("lean").position[2] == pytest.approx(0.075, abs=2e-3)


@pytest.mark.parametrize("from_the_wall", [0.018, 0.022, 0.026])
def test_fingers_do_not_close_on_a_wall_between_them_and_a_body(
    cell: SimulatedCell, from_the_wall: float
) -> None:
    box = Body("box", tub((0.105, 0.105, 0.035)), (0.5, 0.0, 0.02), mass=0.0)
    place = 0.5 - 0.075, -0.105 + from_the_wall, 0.0375
    cell.reset([box, Body("item", Box((0.015, 0.015, 0.0325)), place)], 0)
    pick(cell, "item")


def test_a_cube_in_a_corner_of_two_others_is_pushed_free(cell: SimulatedCell) -> None:
    cell.reset([cube("a", 0.5, 0.0), cube("b", 0.5505, 0.0), cube("c", 0.5, 0.0505)], 0)
    assert move_above(cell, "a", seed=0).evidence["descent_free"] is False
    motion = grasp(cell, "a", seed=0)
    assert motion.achieved and motion.evidence["pushes"] >= 1


def test_a_push_topples_a_tower(cell: SimulatedCell) -> None:
    cell.reset([cube("low", 0.5, 0.0), cube("high", 0.5, 0.0, 3 * HALF)], 0)
    cell.push("high", 0.12, (1.0, 0.0))
    assert cell.pose("high").position[2] < 0.06


def test_an_unknown_body_is_a_reason_and_nothing_moves(cell: SimulatedCell) -> None:
    cell.reset(scattered(0), 0)
    before, joints = cell.poses(), cell.joint_positions()
    for motion in (move_above(cell, "nobody", 0), grasp(cell, "nobody", 0)):
        assert motion.reason is Reason.UNKNOWN_BODY
        assert motion.evidence["known"] == sorted(before)
    assert cell.poses() == before and np.array_equal(cell.joint_positions(), joints)


def test_a_body_out_of_reach_is_a_reason_and_nothing_moves(cell: SimulatedCell) -> None:
    cell.reset([cube("far", 1.2, 0.0)], 0)
    before = cell.time
    assert move_above(cell, "far", 0).reason is Reason.UNREACHABLE
    assert cell.time == before


def test_a_pose_that_is_not_finite_is_refused_and_the_cell_stays_as_it_was(cell: SimulatedCell) -> None:
    cell.reset(scattered(0), 0)
    before = cell.poses()
    with pytest.raises(UnusablePose):
        cell.reset([cube("lost", math.nan, 0.0)], 0)
    assert cell.poses() == before


def test_a_full_or_misplaced_hand_is_a_reason(cell: SimulatedCell) -> None:
    cell.reset(scattered(5), 5)
    assert grasp(cell, "b0", 0).reason is Reason.NOT_ABOVE
    assert release(cell, 0).achieved  # an empty hand just opens
    pick(cell, "b0")
    assert grasp(cell, "b1", 0).reason is Reason.HAND_FULL
    assert move_above(cell, "b0", 0).reason is Reason.TARGET_IN_HAND


def test_a_tilted_support_is_a_reason(cell: SimulatedCell) -> None:
    half = math.sin(math.pi / 8), math.cos(math.pi / 8)
    lean = Body("lean", Box((HALF,) * 3), (0.5, 0.0, 0.06), (half[0], 0.0, 0.0, half[1]))
    cell.reset([lean, cube("prop", 0.5, 0.055), cube("wall", 0.5, -0.052), cube("a", 0.4, -0.15)], 0)
    pick(cell, "a")
    if abs(cell.pose("lean").position[2] - HALF) > 0.002:
        assert move_above(cell, "lean", 0).reason is Reason.SUPPORT_TILTED


def episode(cell: SimulatedCell) -> tuple[object, ...]:
    cell.reset(scattered(7), 7)
    motions: list[Motion] = [
        move_above(cell, "b0", 1),
        grasp(cell, "b0", 2),
        move_above(cell, "b1", 3, slip_at=0.5),
        move_above(cell, "b0", 4),
        grasp(cell, "b0", 5),
        move_above(cell, "b1", 6),
        release(cell, 7),
    ]
    results = [(m.achieved, m.reason, m.simulated_seconds, m.planner, str(m.evidence)) for m in motions]
    return (tuple(results), cell.poses(), cell.joint_positions().tolist())


def test_an_episode_repeats_bit_for_bit(cell: SimulatedCell) -> None:
    first = episode(cell)
    cell.reset(scattered(8), 8)
    pick(cell, "b3")  # something else in between
    assert episode(cell) == first
    with type(cell)() as other:
        assert episode(other) == first


def test_frames_are_called_ten_times_a_simulated_second(cell: SimulatedCell) -> None:
    cell.reset(scattered(0), 0)
    times: list[float] = []
    cell.on_frame = lambda: times.append(cell.time)
    move_above(cell, "b0", 0)
    cell.on_frame = None
    assert times and np.allclose(np.diff(times), 0.1)


def test_a_picture_shows_the_colours(cell: SimulatedCell) -> None:
    red = Body("red", Box((HALF,) * 3), (0.5, 0.0, HALF), colour=(1.0, 0.0, 0.0, 1.0))
    cell.reset([red], 0)
    picture = cell.render(160, 120)
    assert picture.shape == (120, 160, 3) and picture.dtype == np.uint8
    redness = picture[..., 0].astype(int) - picture[..., 1:].max(axis=2)
    assert (redness > 80).sum() > 20


@pytest.mark.needs("pybullet")
def test_importing_and_building_a_cell_prints_nothing() -> None:
    program = "from kinematics.simulation.bullet_cell import BulletCell\nBulletCell().close()"
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True)
    assert (done.returncode, done.stdout) == (0, "")
    assert "build time" not in done.stderr
