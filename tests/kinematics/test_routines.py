"""Skills beyond pick and place: pushing, lifting, opening, stopping, and their failures."""

import math
from pathlib import Path

import numpy as np
import pytest
from kinematics_scenes import HALF, cube, scattered

from kinematics.errors import NoDisplay, Reason
from kinematics.geometry.transforms import transform_of
from kinematics.shapes.bodies import Body
from kinematics.shapes.pose_noise import Noise
from kinematics.shapes.shapes import Box, Cylinder
from kinematics.simulation.bullet_cell import BulletCell
from kinematics.simulation.simulated_cell import SimulatedCell
from kinematics.skills.routines import pick, place
from kinematics.skills.skills import lift, move_above, open_hand, push, release


@pytest.mark.parametrize("seed", range(4))
def test_a_body_is_pushed_to_its_goal(cell: SimulatedCell, seed: int) -> None:
    generator = np.random.default_rng(seed)
    angle, distance = generator.uniform(-math.pi, math.pi), generator.uniform(0.03, 0.12)
    can = Body("can", Cylinder(0.03, 0.06), (0.45, 0.0, 0.03))
    cell.reset([can if seed % 2 else cube("can", 0.45, 0.0, yaw=0.4)], seed)
    before = np.array(cell.pose("can").position)
    motion = push(cell, "can", (math.cos(angle), math.sin(angle)), distance, seed)
    assert motion.achieved, motion
    moved = np.array(cell.pose("can").position) - before
    there = distance * np.array([math.cos(angle), math.sin(angle), 0.0])
    assert float(np.linalg.norm(moved - there)) < 0.015


@pytest.mark.parametrize("height", [0.12, 0.16])
def test_what_a_push_would_topple_is_a_reason_and_nothing_moves(cell: SimulatedCell, height: float) -> None:
    tall = Body("tall", Box((0.02, 0.02, height / 2)), (0.45, 0.0, height / 2))
    cell.reset([tall], 0)
    before = cell.pose("tall")
    assert not push(cell, "tall", (1.0, 0.0), 0.06, 0).achieved
    assert math.dist(cell.pose("tall").position, before.position) < 1e-3


def test_nothing_is_pushed_into_its_neighbour(cell: SimulatedCell) -> None:
    cell.reset([cube("a", 0.5, 0.0), cube("b", 0.5, 0.06)], 0)
    before = cell.time
    assert push(cell, "a", (0.0, 1.0), 0.1, 0).reason is Reason.GOAL_IN_COLLISION
    assert push(cell, "a", (0.0, 0.0), 0.1, 0).reason is Reason.UNUSABLE_POSE
    assert push(cell, "a", (math.nan, 1.0), 0.1, 0).reason is Reason.UNUSABLE_POSE
    assert cell.time == before


def test_a_held_body_is_lifted_and_falls_when_the_hand_opens(cell: SimulatedCell) -> None:
    cell.reset([cube("a", 0.5, 0.0)], 0)
    assert pick(cell, "a", 0).achieved
    before = cell.pose("a").position[2]
    assert lift(cell, 0.1, 0).achieved
    assert cell.pose("a").position[2] == pytest.approx(before + 0.1, abs=2e-3)
    assert lift(cell, 3.0, 0).reason is Reason.UNREACHABLE
    assert open_hand(cell, 0).achieved and cell.held() is None
    cell.settle(0.5)
    assert cell.pose("a").position[2] < 0.06


def test_a_stopped_motion_brakes_and_holds_the_carried_body(cell: SimulatedCell) -> None:
    cell.reset(scattered(3), 3)
    assert pick(cell, "b0", 0).achieved
    started = cell.time

    def stop() -> None:
        if cell.time > started + 0.25:
            cell.stop()

    cell.on_frame = stop
    motion = move_above(cell, "b1", 0)
    cell.on_frame = None
    assert motion.reason is Reason.STOPPED and 0 < motion.evidence["at_fraction"] < 1
    here = cell.joint_positions()
    cell.settle(0.5)
    assert float(np.abs(cell.joint_positions() - here).max()) < 2e-3
    assert cell.held() == "b0"
    assert move_above(cell, "b1", 0).achieved and release(cell, 0).achieved  # and it goes on from there


def test_noise_is_on_observed_poses_and_not_on_true_ones(cell: SimulatedCell) -> None:
    cell.reset(scattered(2), 2, Noise(0.002, math.radians(2)))
    exact, observed = cell.poses(), cell.observed_poses()
    assert exact == cell.poses() and observed != cell.observed_poses()
    offs = [np.subtract(observed[name].position, exact[name].position) for name in exact]
    assert 2e-4 < float(np.std(offs)) < 5e-3
    assert transform_of(observed["b0"])[2, 2] == pytest.approx(1.0, abs=1e-6)
    with pytest.raises(ValueError, match="noise needs two numbers"):
        Noise(-1.0)


def test_a_guarded_descent_places_a_cube_on_a_support_of_uncertain_height(cell: SimulatedCell) -> None:
    cell.reset(scattered(5), 5, Noise(0.005, math.radians(2)))
    for motion in (pick(cell, "b0", 5), place(cell, "b1", 5)):
        assert motion.achieved, motion
    cell.settle(0.3)
    assert cell.contacts("b0", "b1")
    assert cell.pose("b0").position[2] == pytest.approx(3 * HALF, abs=2e-3)


def test_a_window_without_a_display_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("DISPLAY", raising=False)
    with pytest.raises(NoDisplay, match="no display"):
        BulletCell(gui=True)
    monkeypatch.setenv("DISPLAY", ":4711")
    with pytest.raises(NoDisplay, match=":4711 does not answer|no X11 library"):
        BulletCell(gui=True)


def test_pictures_have_the_requested_size(cell: SimulatedCell) -> None:
    cell.reset([cube("a", 0.5, 0.0)], 0)
    for width, height in ((64, 64), (200, 120)):
        assert cell.render(width, height).shape == (height, width, 3)


def test_a_recording_in_three_dimensions_is_written(cell: SimulatedCell, tmp_path: Path) -> None:
    pytest.importorskip("rerun")
    from kinematics.simulation.rerun_recording import Recording

    cell.reset([cube("a", 0.5, 0.0), Body("can", Cylinder(0.03, 0.06), (0.4, 0.1, 0.03))], 0)
    seen: list[float] = []
    cell.on_frame = lambda: seen.append(cell.time)
    path = tmp_path / "cell.rrd"
    with Recording(cell, path):
        assert move_above(cell, "a", 0).achieved
    cell.on_frame = None
    assert seen and path.stat().st_size > 100_000  # the meshes of the arm are in it
