"""An impossible motion has a reason, and leaves the world as it was."""

import math
from collections.abc import Callable, Iterator

import numpy as np
import pytest
from kinematics_scenes import cube, scattered

from kinematics.errors import Reason, UnusablePose, UnusableShape
from kinematics.geometry.transforms import Array, Pose
from kinematics.grasping.grasps import grasps_by_cost
from kinematics.grasping.placements import placements
from kinematics.ik import global_ik
from kinematics.ik.differential_ik import StraightLines
from kinematics.ik.global_ik import InverseKinematics
from kinematics.planning.planner import Planner
from kinematics.robot.gripper import gripper_of
from kinematics.robot.robot import panda
from kinematics.shapes.bodies import Body
from kinematics.shapes.shapes import Box, Compound, Cylinder, Hull, Shape, Sphere
from kinematics.simulation.bullet_cell import BulletCell
from kinematics.simulation.simulated_cell import SimulatedCell
from kinematics.skills import skills
from kinematics.skills.skills import Motion, grasp, move_above

NAN, INF = math.nan, math.inf


class JammedCell(BulletCell):
    """A cell whose gripper no longer opens once it is jammed."""

    jammed = False

    def open_fingers(self, *how: float) -> None:
        if not self.jammed:
            super().open_fingers(*how)


@pytest.fixture
def jammed() -> Iterator[JammedCell]:
    with JammedCell() as cell:
        yield cell


def state(cell: SimulatedCell) -> tuple[object, ...]:
    return cell.time, cell.poses(), cell.joint_positions().tolist(), cell.finger_width()


@pytest.mark.parametrize(
    "skill",
    [
        lambda cell: skills.move_above_place(cell, NAN, 0.0, 0),
        lambda cell: skills.move_above_place(cell, 0.5, INF, 0),
        lambda cell: skills.move_above_places(cell, [(0.5, 0.0), (0.5, NAN)], 0.0, 0),
        lambda cell: skills.move_above_places(cell, [(0.5, 0.0)], NAN, 0),
        lambda cell: skills.move_above_free_place(cell, 0, region=((0.4, NAN), (-0.1, 0.1))),
        lambda cell: skills.move_above(cell, "b0", 0, slip_at=NAN),
        lambda cell: skills.lift(cell, NAN, 0),
        lambda cell: skills.push(cell, "b0", (1.0, 0.0), NAN, 0),
    ],
)
def test_a_skill_refuses_arguments_that_are_not_finite(
    cell: SimulatedCell, skill: Callable[[SimulatedCell], Motion]
) -> None:
    cell.reset(scattered(0), 0)
    before = state(cell)
    motion = skill(cell)
    assert motion.reason is Reason.UNUSABLE_POSE and "nan" in motion.evidence["message"].replace("inf", "nan")
    assert state(cell) == before


@pytest.mark.parametrize(
    "shape",
    [
        Box((0.0, 0.1, 0.1)),
        Box((NAN, 0.1, 0.1)),
        Cylinder(-0.1, 0.1),
        Sphere(INF),
        Hull(((0, 0, 0), (1, 0, 0), (0, 1, 0))),
        Hull(((0, 0, 0), (1, 0, 0), (0, 1, 0), (1, 1, 0))),
        Compound(()),
    ],
)
def test_a_body_without_volume_is_refused_and_the_cell_stays_as_it_was(
    cell: SimulatedCell, shape: Shape
) -> None:
    cell.reset(scattered(0), 0)
    before = state(cell)
    with pytest.raises(UnusableShape, match="'flat' has a piece without volume"):
        cell.reset([Body("flat", shape, (0.5, 0.0, 0.1))], 0)
    assert state(cell) == before


@pytest.mark.parametrize("mass", [-1.0, NAN, INF])
def test_a_body_of_an_impossible_mass_is_refused(cell: SimulatedCell, mass: float) -> None:
    with pytest.raises(UnusableShape, match="'heavy' needs a mass"):
        cell.reset([Body("heavy", Box((0.02,) * 3), (0.5, 0.0, 0.02), mass=mass)], 0)


def test_solver_and_planner_refuse_numbers_that_are_not_finite_or_beyond_a_limit() -> None:
    robot = panda()
    solver = InverseKinematics(robot)
    nowhere = np.full((4, 4), NAN)
    with pytest.raises(UnusablePose, match="the tool"):
        list(solver.solutions(nowhere, solver.starts(nowhere, robot.home, 0, 5)))
    planner = Planner(robot)
    for wrong in (np.full(robot.dof, NAN), robot.limits.upper + 0.1):
        for ends, end in (((robot.home, wrong), "goal"), ((wrong, robot.home), "start")):
            with pytest.raises(UnusablePose, match=f"the {end} of the motion"):
                planner.plan(*ends, lambda q: True, seed=0)


def _transforms_that_are_none() -> dict[str, Array]:
    down = global_ik.tool_pointing_down(0.5, 0.0, 0.2)
    changes = {
        "mirrored": ((slice(0, 3), 0), -down[:3, 0]),
        "scaled": ((slice(0, 3), slice(0, 3)), 1.1 * down[:3, :3]),
        "sheared": ((0, 1), 0.2),
        "zero": ((slice(0, 3), slice(0, 3)), 0.0),
        "no number": ((0, 3), NAN),
        "infinite": ((2, 3), -INF),
        "projective": ((3, 0), 0.1),
    }
    found = {name: down.copy() for name in changes}
    for name, (where, value) in changes.items():
        found[name][where] = value
    return found | {"of three rows": down[:3]}


@pytest.mark.parametrize("name", _transforms_that_are_none())
def test_a_target_that_is_no_transform_has_no_solutions_but_an_error(name: str) -> None:
    target, robot = _transforms_that_are_none()[name], panda()
    solver, lines = InverseKinematics(robot), StraightLines(robot)
    at_home = iter([robot.home])
    for question in (
        lambda: list(solver.solutions(target, at_home)),
        lambda: solver.solve(target, robot.home),
        lambda: lines.follow(robot.home, [solver.forward(robot.home), target]),
        lambda: placements(target, Box((0.02,) * 3), np.eye(3), 0.0),
    ):
        with pytest.raises(UnusablePose, match="no usable pose"):
            question()


@pytest.mark.parametrize("rotation", [np.diag([1.0, 1.0, -1.0]), 2 * np.eye(3), np.full((3, 3), NAN)])
def test_grasps_and_placements_refuse_what_is_no_rotation(rotation: Array) -> None:
    box = Box((0.02, 0.02, 0.02))
    with pytest.raises(UnusablePose, match="'the tool'"):
        placements(np.eye(4), box, rotation, 0.0)
    with pytest.raises(UnusablePose, match="'the yaw'"):
        placements(np.eye(4), box, np.eye(3), NAN)
    for quaternion in ((0.0, 0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 2.0), (0.0, 0.0, NAN, 1.0)):
        with pytest.raises(UnusablePose, match="'the body'"):
            next(grasps_by_cost(Pose((0.5, 0.0, 0.02), quaternion), box, gripper_of(panda())))


def test_a_gripper_that_stays_closed_is_noticed_before_it_comes_down(jammed: JammedCell) -> None:
    jammed.reset([cube("a", 0.5, 0.0)], 0)
    jammed.close_fingers()
    jammed.settle(0.5)
    jammed.jammed = True
    assert move_above(jammed, "a", 0).achieved
    before, joints = jammed.pose("a"), jammed.joint_positions()
    motion = grasp(jammed, "a", 0)
    assert motion.reason is Reason.HAND_CLOSED
    assert motion.evidence["finger_width"] < motion.evidence["needed"] == pytest.approx(0.05)
    assert math.dist(jammed.pose("a").position, before.position) < 1e-5
    assert float(np.abs(jammed.joint_positions() - joints).max()) < 1e-3


def test_a_closed_gripper_opens_by_itself_where_it_can(cell: SimulatedCell) -> None:
    cell.reset([cube("a", 0.5, 0.0)], 0)
    cell.close_fingers()
    cell.settle(0.5)
    assert move_above(cell, "a", 0).achieved and grasp(cell, "a", 0).achieved
    assert cell.held() == "a"


def test_a_body_under_a_lid_cannot_be_grasped_and_nothing_moves(cell: SimulatedCell) -> None:
    lid = Body("lid", Box((0.12, 0.12, 0.02)), (0.5, 0.0, 0.075), mass=0.0)
    cell.reset([cube("low", 0.5, 0.0), lid], 0)
    above = move_above(cell, "low", 0)
    assert above.achieved and above.evidence["descent_free"] is False  # over the lid it can be
    before = state(cell)
    assert grasp(cell, "low", 0).reason is Reason.NO_GRASP
    assert state(cell) == before


CORNERS = tuple((x, y, z) for x in (-0.045, 0.045) for y in (-0.045, 0.045) for z in (-0.02, 0.02))


@pytest.mark.parametrize("shape", [Cylinder(0.0375, 0.04), Box((0.05, 0.045, 0.02)), Hull(CORNERS)])
def test_a_body_wider_than_the_hand_opens_is_a_reason(cell: SimulatedCell, shape: Shape) -> None:
    cell.reset([Body("lid", shape, (0.5, 0.0, 0.02))], 0)
    cell.settle(0.5)
    before = state(cell)
    motion = move_above(cell, "lid", 0)
    assert motion.reason is Reason.NO_GRASP
    assert "mm wide at its narrowest, and the hand opens for 73 mm" in motion.evidence["message"]
    assert state(cell) == before
