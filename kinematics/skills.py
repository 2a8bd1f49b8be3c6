"""What the arm can do: four skills, each from a cell and a seed to a `Motion`.

A skill looks, plans, moves and looks again. What cannot be done is a `Motion` with a reason, never an exception.
"""

import itertools
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from functools import cache
from typing import Any

import numpy as np

from kinematics import differential, inverse, motion
from kinematics.approach import (
    ABOVE_SUPPORT,
    Approach,
    corners_of,
    grasp_approaches,
    line_to_grasp,
    opening_that_is_free,
    placement_approaches,
    still_above,
    top_of,
)
from kinematics.arm import Arm, Look
from kinematics.geometry import Array, angle_between, rotation_from_quaternion
from kinematics.grasps import grasps_by_trouble
from kinematics.nudge import Nudge, nudges
from kinematics.placements import Region, free_places, yaw_of
from kinematics.reasons import (
    KinematicsError,
    NoPlaceFound,
    Obstructed,
    Reason,
    Unreachable,
    UnsuitableHand,
)
from kinematics.robot import MAXIMUM_OPENING
from kinematics.simulation import Workcell
from kinematics.trajectory import Trajectory, round_corners, time_parameterise

REGION: Region = ((0.3, 0.7), (-0.2, 0.2))
NUDGES = 4  # before a grasp is given up
NUDGE_SPEED = 0.1  # of the tool [m/s]
LINE_SPEED = 0.35  # of the tool on straight lines [m/s]
WIDTH_TOLERANCE = 0.006  # between the fingers and the body's width [m]
STAYED = 0.005  # how far a body may be from where it was let go [m]
MAXIMUM_DROP = 1.0  # of a held body to what is below [m]
APPROACHES = 4  # that are planned to before a skill gives up
_TURNED = 0.05  # a grasp whose rotation is so near the tool's is the one it waits above [rad]


@dataclass(frozen=True)
class Motion:
    """What came of a skill."""

    achieved: bool
    reason: Reason | None = None
    evidence: dict[str, Any] = field(default_factory=dict)
    planning_seconds: float = 0.0  # wall
    moving_seconds: float = 0.0  # wall
    simulated_seconds: float = 0.0
    solver: str = ""
    planner: str = ""


@dataclass
class _Report:
    """What a skill says about itself while it runs."""

    evidence: dict[str, Any] = field(default_factory=dict)
    solvers: list[str] = field(default_factory=list)
    planner: str = ""
    failure: Reason | None = None

    def solved_by(self, solver: str) -> None:
        if solver not in self.solvers:
            self.solvers.append(solver)


def move_above(cell: Workcell, target: str, seed: int, slip_at: float | None = None) -> Motion:
    """The tool to 10 cm above the top of a body; what is held is then centred over it and aligned.

    Args:
        slip_at: the fraction of the way at which the fingers lose their force (a disturbance).
    """

    def skill(arm: Arm, report: _Report) -> None:
        cell.pose(target)
        look = arm.look(cell)
        if look.held == target:
            raise UnsuitableHand(Reason.TARGET_IN_HAND, f"'{target}' is in the hand", name=target)
        size = cell.bodies[target].half_extents
        if look.held is None:
            approaches = grasp_approaches(arm, look, target, size, seed)
        else:
            x, y, _ = look.poses[target].position
            yaw = yaw_of(rotation_from_quaternion(look.poses[target].quaternion_xyzw))
            approaches = placement_approaches(
                arm, look, cell.bodies[look.held].half_extents,
                (x, y, top_of(look, target, size)), [yaw], seed,
            )
        _go_above(cell, arm, look, approaches, seed, slip_at, report)

    return _perform(cell, skill)


def move_above_free_place(
    cell: Workcell, seed: int, slip_at: float | None = None, region: Region = REGION
) -> Motion:
    """The tool to 10 cm above the clearest free place of the table within the region."""

    def skill(arm: Arm, report: _Report) -> None:
        look = arm.look(cell)
        sizes = {name: body.half_extents for name, body in cell.bodies.items()}
        places = _places(look, sizes, region)
        report.evidence["free_places"] = len(places)

        def approaches() -> Iterator[Approach]:
            for x, y in places[:12]:
                held = look.held
                if held is None:
                    yield from _empty_hand_approaches(arm, look, x, y, seed)
                else:
                    yaws = [yaw_of(look.tool[:3, :3]), 0.0]
                    found = placement_approaches(arm, look, sizes[held], (x, y, 0.0), yaws, seed)
                    yield from (approach for approach in found if approach.is_free)

        _go_above(cell, arm, look, approaches(), seed, slip_at, report)

    return _perform(cell, skill)


def grasp(cell: Workcell, target: str, seed: int) -> Motion:
    """Straight down, close, and straight up again with the body; verified by finger width and pose."""

    def skill(arm: Arm, report: _Report) -> None:
        cell.pose(target)
        look = arm.look(cell)
        if look.held is not None:
            raise UnsuitableHand(Reason.HAND_FULL, f"the hand holds '{look.held}'", held=look.held)
        if not still_above(look, target):
            raise KinematicsError(Reason.NOT_ABOVE, f"the tool is not above '{target}'")
        approach = _approach_from_here(arm, look, cell, target)
        if approach is None:
            approach = _approach_anew(cell, arm, target, seed, report)
        report.solved_by(differential.SOLVER)
        _take(cell, target, approach, report)

    return _perform(cell, skill)


def release(cell: Workcell, seed: int) -> Motion:
    """Straight down until the held body rests on what is below, open, straight up. An empty hand just opens."""

    def skill(arm: Arm, report: _Report) -> None:
        look = arm.look(cell)
        if look.held is None:
            motion.open_hand(cell, MAXIMUM_OPENING)
            return
        report.solved_by(differential.SOLVER)
        line, opening = _line_down(arm, look, look.held)
        _put(cell, look.held, line, opening, report)

    return _perform(cell, skill)


@cache
def _arm() -> Arm:
    """One set of solvers a process; they hold nothing of a cell that `Arm.look` does not renew."""
    return Arm()


def _perform(cell: Workcell, skill: Callable[[Arm, _Report], None]) -> Motion:
    """Run a skill, with the clocks around it; failures become reasons."""
    arm, report = _arm(), _Report()
    started, simulated, stepping = time.perf_counter(), cell.time, cell.stepping_seconds
    try:
        skill(arm, report)
    except KinematicsError as failure:
        report.failure = failure.reason
        report.evidence.update(failure.evidence, message=str(failure))
    moving = cell.stepping_seconds - stepping
    return Motion(
        achieved=report.failure is None,
        reason=report.failure,
        evidence=report.evidence,
        planning_seconds=time.perf_counter() - started - moving,
        moving_seconds=moving,
        simulated_seconds=cell.time - simulated,
        solver="+".join(report.solvers),
        planner=report.planner,
    )


def _go_above(
    cell: Workcell, arm: Arm, look: Look, approaches: Iterator[Approach], seed: int,
    slip_at: float | None, report: _Report,
) -> Approach:
    """Plan to the first approach that a path leads to, and move there."""
    failure: KinematicsError | None = None
    report.solved_by(inverse.SOLVER)
    for approach, _ in zip(approaches, range(APPROACHES), strict=False):
        arm.scene.open_fingers(look.opening)
        arm.show_held(look)
        try:
            path = arm.plan(look.q, approach.above, seed)
        except KinematicsError as found:
            failure = found
            continue
        report.planner = path.planner
        report.evidence.update(
            validity_checks=path.checks, descent_free=approach.is_free, trouble=approach.trouble
        )
        dense = round_corners(path.corners, arm.chain_is_free)
        _travel(cell, look, time_parameterise(dense), slip_at, report)
        return approach
    raise failure or _no_approach(arm)


def _no_approach(arm: Arm) -> KinematicsError:
    if arm.near:
        return Obstructed(
            Reason.GOAL_IN_COLLISION, "something stands where the arm would be",
            near=sorted(arm.near),
        )
    return Unreachable(Reason.UNREACHABLE, "no joint positions put the tool there")


def _travel(
    cell: Workcell, look: Look, trajectory: Trajectory, slip_at: float | None, report: _Report
) -> None:
    if look.held is None:
        motion.follow(cell, trajectory)
        return
    grip = motion.measure_grip(cell, look.held)
    drop = motion.carry(cell, trajectory, grip, slip_at)
    if drop is None:
        return
    motion.open_hand(cell, MAXIMUM_OPENING)
    cell.settle_until_still([drop.name], motion.WAIT_FOR_FALL)
    raise KinematicsError(
        Reason.OBJECT_DROPPED, f"'{drop.name}' was lost on the way", name=drop.name,
        at_fraction=drop.at_fraction, finger_width=drop.finger_width, slid=drop.slid,
        lies_at=cell.pose(drop.name).position, forced=slip_at is not None,
    )


def _approach_from_here(arm: Arm, look: Look, cell: Workcell, target: str) -> Approach | None:
    """The line down from where the arm is, to a grasp in the orientation that the tool has."""
    half_extents = cell.bodies[target].half_extents
    for group in grasps_by_trouble(look.poses[target], half_extents):
        for option in group:
            if angle_between(option.tool[:3, :3], look.tool[:3, :3]) < _TURNED:
                end = arm.inverse.solve(option.tool, look.q)
                approach = None if end is None else line_to_grasp(arm, look.q, option, end)
                if approach is not None:
                    return approach
    return None


def _approach_anew(
    cell: Workcell, arm: Arm, target: str, seed: int, report: _Report
) -> Approach:
    """Move to where the way down is free; where there is none, push the body free of its neighbours."""
    half_extents = cell.bodies[target].half_extents
    for attempt in range(NUDGES + 1):
        look = arm.look(cell)
        found = grasp_approaches(arm, look, target, half_extents, seed)
        free = (approach for approach in found if approach.is_free)
        first = next(free, None)
        if first is not None:
            approaches = itertools.chain([first], free)
            return _go_above(cell, arm, look, approaches, seed, None, report)
        sizes = {name: body.half_extents for name, body in cell.bodies.items()}
        nudge = next(nudges(arm, look, target, sizes, seed), None)
        if nudge is None or attempt == NUDGES:
            break
        _push_free(cell, arm, look, nudge, seed, report)
    raise Obstructed(
        Reason.NO_GRASP, f"no grasp of '{target}' is free", nudges=report.evidence.get("nudges", 0)
    )


def _push_free(
    cell: Workcell, arm: Arm, look: Look, nudge: Nudge, seed: int, report: _Report
) -> None:
    report.evidence["nudges"] = report.evidence.get("nudges", 0) + 1
    arm.scene.open_fingers(0.0)
    motion.open_hand(cell, 0.0)
    path = arm.plan(look.q, nudge.above, seed)
    motion.follow(cell, time_parameterise(round_corners(path.corners, arm.chain_is_free)))
    down, sweep = _along(nudge.down), _along(nudge.sweep, NUDGE_SPEED)
    motion.follow(cell, down)
    motion.follow(cell, sweep)
    motion.follow(cell, _along(nudge.sweep[::-1][:3]))
    up = arm.lines.follow(nudge.sweep[-3], [_raised(arm, nudge.sweep[-3], nudge.above)])
    if up is not None:
        motion.follow(cell, _along(up))
    motion.open_hand(cell, MAXIMUM_OPENING)


def _raised(arm: Arm, q: Array, above: Array) -> Array:
    """The tool as at `q`, as high as at `above`."""
    raised = arm.inverse.forward(q)
    raised[2, 3] = arm.inverse.forward(above)[2, 3]
    return raised


def _take(cell: Workcell, target: str, approach: Approach, report: _Report) -> None:
    down = _along(approach.line)
    motion.open_hand(cell, approach.opening)
    motion.follow(cell, down)
    motion.close_hand(cell)
    failure = _grasp_failure(cell, target, report)
    if failure is None:
        grip = motion.measure_grip(cell, target)
        drop = motion.carry(cell, down.reversed(), grip)
        if drop is None and cell.held() == target:
            report.evidence["in_hand"] = tuple(motion.measure_grip(cell, target).offset.tolist())
            return
        failure = KinematicsError(Reason.GRASP_SLIPPED, f"'{target}' slipped while it was lifted")
        motion.open_hand(cell, MAXIMUM_OPENING)
        _go_back(cell, approach.above)
        cell.settle_until_still([target], motion.WAIT_FOR_FALL)
        raise failure
    motion.open_hand(cell, approach.opening)
    motion.follow(cell, down.reversed())
    raise failure


def _grasp_failure(cell: Workcell, target: str, report: _Report) -> KinematicsError | None:
    """None where the hand holds the target: by contact, by finger width and by the body's pose."""
    width = cell.finger_width()
    sizes = [2 * half for half in cell.bodies[target].half_extents]
    report.evidence.update(finger_width=width, held=cell.held())
    fits = min(abs(width - size) for size in sizes) < WIDTH_TOLERANCE
    if fits and cell.held() == target:
        return None
    return KinematicsError(
        Reason.GRASP_FAILED, f"the fingers are {1000 * width:.1f} mm apart and hold {cell.held()}"
    )


def _go_back(cell: Workcell, above: Array) -> None:
    """Straight in the joints from wherever a lift was broken off: the rest of that lift, nearly."""
    motion.follow(cell, time_parameterise(np.array([cell.joint_positions(), above])))


def _line_down(arm: Arm, look: Look, held: str) -> tuple[Array, float]:
    """The line to where the held body rests on what is below, and how wide to open there."""
    drop = arm.scene.drop_height(look.q, held, MAXIMUM_DROP) - ABOVE_SUPPORT
    low = look.tool.copy()
    low[2, 3] -= max(0.0, drop)
    line = arm.lines.follow(look.q, [low])
    if line is None:
        raise Unreachable(Reason.UNREACHABLE, "no straight line leads down to the support")
    if not arm.chain_is_free(line[:-1], margin=0.0):
        touches = sorted({touch.names for q in line[:-1] for touch in arm.scene.touches(q)})
        raise Obstructed(
            Reason.GOAL_IN_COLLISION, "something stands beside the way down", near=touches
        )
    arm.scene.hold(None)
    width = 2 * look.opening
    opening = opening_that_is_free(arm, line, width)
    return line, width / 2 + 0.004 if opening is None else opening


def _put(cell: Workcell, held: str, line: Array, opening: float, report: _Report) -> None:
    down = _along(line)
    grip = motion.measure_grip(cell, held)
    drop = motion.carry(cell, down, grip)
    if drop is not None:
        motion.open_hand(cell, opening)
        raise KinematicsError(Reason.OBJECT_DROPPED, f"'{held}' was lost on the way down", name=held)
    put_at = np.array(cell.pose(held).position)
    motion.open_hand(cell, opening)
    motion.follow(cell, down.reversed())
    moved = float(np.linalg.norm(np.array(cell.pose(held).position) - put_at))
    report.evidence.update(moved=moved, speed=cell.speed(held))
    if moved > STAYED or cell.speed(held) > 0.1:
        cell.settle_until_still([held], motion.WAIT_FOR_FALL)
        raise KinematicsError(
            Reason.PLACEMENT_FAILED, f"'{held}' did not stay where it was put", moved=moved
        )


def _along(line: Array, speed: float = LINE_SPEED) -> Trajectory:
    """A straight line of the tool, at its own speed [m/s]."""
    solver = inverse.InverseKinematics()
    length = float(np.linalg.norm(solver.forward(line[-1])[:3, 3] - solver.forward(line[0])[:3, 3]))
    return time_parameterise(line, speed, length)


def _places(look: Look, sizes: dict[str, Any], region: Region) -> list[tuple[float, float]]:
    held = look.held
    if held is None:
        sizes, held = {**sizes, "": (0.01, 0.01, 0.01)}, ""
    places = free_places(look.poses, sizes, held, region)
    if not places:
        raise NoPlaceFound(Reason.NO_FREE_PLACE, "the table has no free place of that size")
    return places


def _empty_hand_approaches(
    arm: Arm, look: Look, x: float, y: float, seed: int
) -> Iterator[Approach]:
    above = inverse.usual_tool(x, y, 0.10)
    for q in arm.solutions(above, look.q, seed, 2):
        yield Approach(q, q[None], look.opening, 0.0)
