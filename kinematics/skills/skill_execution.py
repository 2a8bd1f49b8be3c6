"""One execution of a skill: from snapshots of the cell to motions, grasps and releases."""

from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import partial
from typing import Any

import numpy as np

from kinematics.collision.models import MARGIN
from kinematics.errors import KinematicsError, Obstructed, Reason, Unreachable, UnsuitableHand
from kinematics.geometry.transforms import Array, angle_between
from kinematics.grasping.grasps import grasps_by_cost
from kinematics.ik import differential_ik, global_ik
from kinematics.planning.trajectory import Trajectory, round_corners, time_parameterise
from kinematics.shapes.shapes import Shape
from kinematics.simulation.cell import Cell
from kinematics.skills import execution
from kinematics.skills.approach import Approach, line_to_grasp
from kinematics.skills.arm import Arm, CellSnapshot

LINE_SPEED = 0.35  # of the tool on straight lines [m/s]
WIDTH_TOLERANCE = 0.006  # between finger width and the body's width [m]
SWINGING_TOLERANCE = 0.012  # the same for fingers on hinges, which give way [m]
APPROACHES = 4  # to which paths are planned before a skill gives up
OFF_CENTRE = 0.025  # of a body from its expected position in the hand, for a grasp to count [m]
NARROWING = 1e-3  # of the fingers that is worth a command [m]
_SAME_ROTATION = 0.05  # of tool and grasp, for a grasp right below the tool [rad]


@dataclass
class SkillExecution:
    """A cell, the arm's solvers, and the evidence for the resulting `Motion`."""

    cell: Cell
    arm: Arm
    seed: int
    evidence: dict[str, Any] = field(default_factory=dict)
    solvers: list[str] = field(default_factory=list)
    planner: str = ""

    def shape(self, name: str) -> Shape:
        """Return the shape of a body of the cell."""
        return self.cell.bodies[name].shape

    def open_wide(self) -> None:
        """Open the hand as wide as it goes."""
        execution.open_hand(self.cell, self.arm.gripper.maximum_opening)

    def observe(self) -> CellSnapshot:
        """Return a new snapshot of the cell."""
        return self.arm.observe(self.cell)

    def solved_by(self, solver: str) -> None:
        """Note a solver that contributed."""
        if solver not in self.solvers:
            self.solvers.append(solver)

    # -- above -----------------------------------------------------------------------------

    def go_above(
        self, snapshot: CellSnapshot, approaches: Iterator[Approach], slip_at: float | None = None
    ) -> Approach:
        """Move to the first approach that a path is found to, and return it."""
        failure: KinematicsError | None = None
        self.solved_by(global_ik.SOLVER)
        for approach, _ in zip(approaches, range(APPROACHES), strict=False):
            opening = snapshot.opening
            if snapshot.held is None:  # there may be no room for wider fingers at the goal
                opening = min(opening, approach.opening)
            try:
                trajectory = self.plan_to(snapshot, approach.above, opening)
            except KinematicsError as found:
                failure = found
                continue
            self.evidence.update(descent_free=approach.is_free, cost=approach.cost)
            if opening < snapshot.opening - NARROWING:
                execution.open_hand(self.cell, opening)
            self._follow(snapshot, trajectory, slip_at)
            return approach
        raise failure or self._approach_failure()

    def plan_to(self, snapshot: CellSnapshot, goal: Array, opening: float) -> Trajectory:
        """Return a trajectory to joint positions with the fingers at an opening [m]."""
        arm, state = self.arm, snapshot.state.with_opening(opening)
        path = arm.plan(snapshot.q, goal, state, self.seed)
        self.planner = path.planner
        self.evidence["validity_checks"] = path.checks
        free = partial(arm.chain_is_free, state=state, margin=MARGIN)
        return time_parameterise(round_corners(path.corners, free), arm.robot.limits)

    def change_posture(self, snapshot: CellSnapshot, q: Array) -> bool:
        """Move to another posture with what the hand holds; return False if no path leads there."""
        try:
            trajectory = self.plan_to(snapshot, q, snapshot.opening)
        except KinematicsError:
            return False
        self._follow(snapshot, trajectory, None)
        return True

    def _follow(self, snapshot: CellSnapshot, trajectory: Trajectory, slip_at: float | None) -> None:
        if snapshot.held is None:
            execution.follow(self.cell, trajectory)
            return
        grip = execution.measure_grip(self.cell, snapshot.held)
        drop = execution.carry(self.cell, trajectory, grip, slip_at)
        if drop is not None:
            raise self.drop_failure(drop, forced=slip_at is not None)

    def drop_failure(self, drop: execution.Drop, forced: bool = False) -> KinematicsError:
        """Open the hand, wait for the fall to end, and return the failure."""
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

    def _approach_failure(self) -> KinematicsError:
        if self.arm.near:
            return Obstructed(
                Reason.GOAL_IN_COLLISION,
                "something stands where the arm would be",
                near=sorted(self.arm.near),
            )
        return Unreachable(Reason.UNREACHABLE, "no joint positions put the tool there")

    # -- grasp -----------------------------------------------------------------------------

    def approach_from_here(self, snapshot: CellSnapshot, target: str) -> Approach | None:
        """Return the line down from the present position to a grasp with the tool's orientation, if any."""
        for group in grasps_by_cost(snapshot.poses[target], self.shape(target), self.arm.gripper):
            for option in group:
                if angle_between(option.tool[:3, :3], snapshot.tool[:3, :3]) > _SAME_ROTATION:
                    continue
                end = self.arm.inverse.solve(option.tool, snapshot.q)
                approach = (
                    None if end is None else line_to_grasp(self.arm, snapshot.state, snapshot.q, option, end)
                )
                if approach is not None:
                    return approach
        return None

    def take(self, snapshot: CellSnapshot, target: str, approach: Approach) -> None:
        """Go down, close the hand, and go up again the same way."""
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
        """Raise `UnsuitableHand` if the fingers did not open: they would come down on the body."""
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
        """Return None if contact, finger width and the body's pose agree that the target is held."""
        assert approach.grasp is not None
        width, held = self.cell.finger_width(), self.cell.held()
        moved = execution.measure_grip(self.cell, target).offset - approach.grasp.offset
        off = float(np.linalg.norm(moved))
        self.evidence.update(finger_width=width, held=held, off_centre=off)
        tolerance = WIDTH_TOLERANCE if self.arm.gripper.slides else SWINGING_TOLERANCE
        contact_opening = self.arm.scene.contact_opening(approach.grasp.tool, target, snapshot.state)
        widths = approach.grasp.width, 2 * contact_opening
        fits = min(abs(width - each) for each in widths) < tolerance
        if fits and held == target and off < OFF_CENTRE + execution.position_uncertainty(self.cell):
            return None
        return KinematicsError(
            Reason.GRASP_FAILED, f"the fingers are {1000 * width:.1f} mm apart and hold {held or 'nothing'}"
        )

    def _go_back(self, above: Array) -> None:
        """Return to the start of an aborted line, straight in joint space, which is nearly the same path."""
        chain = np.array([self.cell.joint_positions(), above])
        execution.follow(self.cell, time_parameterise(chain, self.arm.robot.limits))

    # -- straight lines -----------------------------------------------------------------------

    def lift(self, snapshot: CellSnapshot, height: float) -> None:
        """Lift the tool straight up by a height [m], with the held body."""
        raised = snapshot.tool.copy()
        raised[2, 3] += height
        self.solved_by(differential_ik.SOLVER)
        line = self.arm.lines.follow(snapshot.q, [raised])
        if line is None:
            raise Unreachable(Reason.UNREACHABLE, "no straight line leads up there")
        if not self.arm.chain_is_free(line[1:], snapshot.state, margin=0.0):
            raise Obstructed(Reason.GOAL_IN_COLLISION, "something is in the way")
        self._follow(snapshot, self.along(line), None)

    def along(self, line: Array, speed: float = LINE_SPEED) -> Trajectory:
        """Return the trajectory along a straight line of the tool, at most at a speed [m/s]."""
        ends = [self.arm.inverse.forward(q)[:3, 3] for q in (line[0], line[-1])]
        return time_parameterise(line, self.arm.robot.limits, speed, float(np.linalg.norm(ends[1] - ends[0])))
