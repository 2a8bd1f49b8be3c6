"""One attempt at a skill: from a look at the cell to paths, grasps, placements and pushes that are
carried out.
"""

from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import partial
from typing import Any

import numpy as np

from kinematics.collision.models import MARGIN
from kinematics.errors import KinematicsError, Obstructed, Reason, Unreachable, UnsuitableHand
from kinematics.geometry.transforms import Array, angle_between
from kinematics.grasping.grasps import grasps_by_trouble
from kinematics.ik import differential_ik, global_ik
from kinematics.planning.trajectory import Trajectory, round_corners, time_parameterise
from kinematics.shapes.shapes import Shape
from kinematics.simulation.workcell import Workcell
from kinematics.skills import execution
from kinematics.skills.approach import Approach, line_to_grasp
from kinematics.skills.arm import Arm, CellSnapshot

LINE_SPEED = 0.35  # of the tool on straight lines [m/s]
WIDTH_TOLERANCE = 0.006  # between the fingers and the body's width [m]
SWINGING_TOLERANCE = 0.012  # the same for fingers on hinges, which give way [m]
APPROACHES = 4  # that are planned to before a skill gives up
OFF_CENTRE = 0.025  # from where it should be in the hand, for a grasp to count [m]
NOTICEABLE = 1e-3  # of a finger's way [m]
_TURNED = 0.05  # a grasp whose rotation is so near the tool's is the one it waits above [rad]


@dataclass
class Attempt:
    """A cell, the arm's solvers, and what is to be said about the attempt afterwards."""

    cell: Workcell
    arm: Arm
    seed: int
    evidence: dict[str, Any] = field(default_factory=dict)
    solvers: list[str] = field(default_factory=list)
    planner: str = ""

    def shape(self, name: str) -> Shape:
        """Of a body of the cell."""
        return self.cell.bodies[name].shape

    def open_wide(self) -> None:
        execution.open_hand(self.cell, self.arm.gripper.maximum_opening)

    def observe(self) -> CellSnapshot:
        return self.arm.observe(self.cell)

    def solved_by(self, solver: str) -> None:
        if solver not in self.solvers:
            self.solvers.append(solver)

    # -- above -----------------------------------------------------------------------------

    def go_above(
        self, snapshot: CellSnapshot, approaches: Iterator[Approach], slip_at: float | None = None
    ) -> Approach:
        """Plan to the first approach that a path leads to, and move there."""
        failure: KinematicsError | None = None
        self.solved_by(global_ik.SOLVER)
        for approach, _ in zip(approaches, range(APPROACHES), strict=False):
            opening = snapshot.opening
            if snapshot.held is None:  # room for wider fingers is not promised there
                opening = min(opening, approach.opening)
            try:
                trajectory = self.plan_to(snapshot, approach.above, opening)
            except KinematicsError as found:
                failure = found
                continue
            self.evidence.update(descent_free=approach.is_free, trouble=approach.trouble)
            if opening < snapshot.opening - NOTICEABLE:
                execution.open_hand(self.cell, opening)
            self._travel(snapshot, trajectory, slip_at)
            return approach
        raise failure or self._no_approach()

    def plan_to(self, snapshot: CellSnapshot, goal: Array, opening: float) -> Trajectory:
        arm, state = self.arm, snapshot.state.with_opening(opening)
        path = arm.plan(snapshot.q, goal, state, self.seed)
        self.planner = path.planner
        self.evidence["validity_checks"] = path.checks
        free = partial(arm.chain_is_free, state=state, margin=MARGIN)
        return time_parameterise(round_corners(path.corners, free), arm.robot.limits)

    def turns_to(self, snapshot: CellSnapshot, q: Array) -> bool:
        """Whether a path leads to another posture; the arm then takes it, with what it holds."""
        try:
            trajectory = self.plan_to(snapshot, q, snapshot.opening)
        except KinematicsError:
            return False
        self._travel(snapshot, trajectory, None)
        return True

    def _travel(self, snapshot: CellSnapshot, trajectory: Trajectory, slip_at: float | None) -> None:
        if snapshot.held is None:
            execution.follow(self.cell, trajectory)
            return
        grip = execution.measure_grip(self.cell, snapshot.held)
        drop = execution.carry(self.cell, trajectory, grip, slip_at)
        if drop is not None:
            raise self.dropped(drop, forced=slip_at is not None)

    def dropped(self, drop: execution.Drop, forced: bool = False) -> KinematicsError:
        """Open the hand, wait for the fall to end, and say what was noticed."""
        self.open_wide()
        self.cell.settle_until_still([drop.name], execution.WAIT_FOR_FALL)
        return KinematicsError(
            Reason.OBJECT_DROPPED,
            f"'{drop.name}' was lost on the way",
            name=drop.name,
            at_fraction=drop.at_fraction,
            finger_width=drop.finger_width,
            slid=drop.slid,
            lies_at=self.cell.pose(drop.name).position,
            forced=forced,
        )

    def _no_approach(self) -> KinematicsError:
        if self.arm.near:
            return Obstructed(
                Reason.GOAL_IN_COLLISION,
                "something stands where the arm would be",
                near=sorted(self.arm.near),
            )
        return Unreachable(Reason.UNREACHABLE, "no joint positions put the tool there")

    # -- grasp -----------------------------------------------------------------------------

    def approach_from_here(self, snapshot: CellSnapshot, target: str) -> Approach | None:
        """The line down from where the arm is, to a grasp in the orientation that the tool has."""
        for group in grasps_by_trouble(snapshot.poses[target], self.shape(target), self.arm.gripper):
            for option in group:
                if angle_between(option.tool[:3, :3], snapshot.tool[:3, :3]) > _TURNED:
                    continue
                end = self.arm.inverse.solve(option.tool, snapshot.q)
                approach = (
                    None if end is None else line_to_grasp(self.arm, snapshot.state, snapshot.q, option, end)
                )
                if approach is not None:
                    return approach
        return None

    def take(self, snapshot: CellSnapshot, target: str, approach: Approach) -> None:
        """Down, close, and up again by the same way backwards."""
        cell, down = self.cell, self.along(approach.line)
        execution.open_hand(cell, approach.opening)
        self._check_open(approach)
        try:
            execution.follow(cell, down)
        except KinematicsError:
            self._go_back(approach.above)
            raise
        execution.close_hand(cell)
        failure = self._grasp_failure(snapshot, target, approach)
        if failure is not None:
            execution.open_hand(cell, approach.opening)
            execution.follow(cell, down.reversed())
            raise failure
        self._lift(target, down.reversed(), approach.above)

    def _check_open(self, approach: Approach) -> None:
        """A hand that was told to open and is not would come down on what it is to take."""
        assert approach.grasp is not None
        width, needed = self.cell.finger_width(), approach.grasp.width
        if width < needed:
            message = f"the fingers are {1000 * width:.1f} mm apart, {1000 * needed:.1f} mm are needed"
            raise UnsuitableHand(Reason.HAND_CLOSED, message, finger_width=width, needed=needed)

    def _lift(self, target: str, up: Trajectory, above: Array) -> None:
        cell = self.cell
        drop = execution.carry(cell, up, execution.measure_grip(cell, target))
        if drop is None and cell.held() == target:
            self.evidence["in_hand"] = tuple(execution.measure_grip(cell, target).offset.tolist())
            return
        self.open_wide()
        self._go_back(above)
        cell.settle_until_still([target], execution.WAIT_FOR_FALL)
        raise KinematicsError(Reason.GRASP_SLIPPED, f"'{target}' slipped while it was lifted")

    def _grasp_failure(
        self, snapshot: CellSnapshot, target: str, approach: Approach
    ) -> KinematicsError | None:
        """None where contact, the finger width and the body's pose say that the target is held."""
        assert approach.grasp is not None
        width, held = self.cell.finger_width(), self.cell.held()
        moved = execution.measure_grip(self.cell, target).offset - approach.grasp.offset
        off = float(np.linalg.norm(moved))
        self.evidence.update(finger_width=width, held=held, off_centre=off)
        tolerance = WIDTH_TOLERANCE if self.arm.gripper.slides else SWINGING_TOLERANCE
        closed_on = self.arm.scene.closed_on(approach.grasp.tool, target, snapshot.state)
        widths = approach.grasp.width, 2 * closed_on
        fits = min(abs(width - each) for each in widths) < tolerance
        if fits and held == target and off < OFF_CENTRE + execution.doubt(self.cell):
            return None
        return KinematicsError(
            Reason.GRASP_FAILED, f"the fingers are {1000 * width:.1f} mm apart and hold {held}"
        )

    def _go_back(self, above: Array) -> None:
        """Straight in the joints, from wherever a line was broken off: the rest of it, nearly."""
        chain = np.array([self.cell.joint_positions(), above])
        execution.follow(self.cell, time_parameterise(chain, self.arm.robot.limits))

    # -- straight lines -----------------------------------------------------------------------

    def lift(self, snapshot: CellSnapshot, height: float) -> None:
        """Straight up [m]; what is held must still be held there."""
        raised = snapshot.tool.copy()
        raised[2, 3] += height
        self.solved_by(differential_ik.SOLVER)
        line = self.arm.lines.follow(snapshot.q, [raised])
        if line is None:
            raise Unreachable(Reason.UNREACHABLE, "no straight line leads up there")
        if not self.arm.chain_is_free(line[1:], snapshot.state, margin=0.0):
            raise Obstructed(Reason.GOAL_IN_COLLISION, "something is in the way up")
        self._travel(snapshot, self.along(line), None)

    def along(self, line: Array, speed: float = LINE_SPEED) -> Trajectory:
        """A straight line of the tool, at its own speed [m/s]."""
        ends = [self.arm.inverse.forward(q)[:3, 3] for q in (line[0], line[-1])]
        return time_parameterise(line, self.arm.robot.limits, speed, float(np.linalg.norm(ends[1] - ends[0])))
