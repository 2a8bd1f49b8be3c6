"""What the arm can do: skills, each from a cell and a seed to a `Motion`.

A skill looks, plans, moves and looks again. What cannot be done is a `Motion` with a reason, never
an exception, and what fails before the arm moves leaves the world as it was.
"""

import math
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from functools import cache
from typing import Any

import numpy as np

from kinematics.errors import KinematicsError, NoPlaceFound, Obstructed, Reason, UnsuitableHand
from kinematics.geometry.transforms import check_finite, rotation_from_quaternion
from kinematics.grasping.grasps import greatest_width, least_width
from kinematics.grasping.placements import free_places, yaw_of
from kinematics.ik import differential_ik, global_ik
from kinematics.robot.robot import Region, Robot
from kinematics.shapes import containers
from kinematics.shapes.shapes import Box, half_extents_of, height_above
from kinematics.simulation.workcell import Workcell
from kinematics.skills import pushing, releasing
from kinematics.skills.approach import (
    CLEARANCE,
    TILTED,
    Approach,
    drop_approaches,
    grasp_approaches,
    placement_approaches,
    still_above,
    tilt_of,
)
from kinematics.skills.arm import Arm, CellSnapshot
from kinematics.skills.skill_execution import Attempt
from kinematics.skills.workspace import workspace_of

PLACES = 12  # of the table that are tried
ROOMY = 0.06  # half of what has room for several things and never moves [m]
EDGE = 0.03  # between the middle of a thing and the edge of what it is put on [m]
_TOOL_SIZE = Box((0.01, 0.01, 0.01))  # of an empty hand that looks for a place [m]


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


def move_above(cell: Workcell, target: str, seed: int, slip_at: float | None = None) -> Motion:
    """The tool to 10 cm above the top of a body; what is held is then centred over it and aligned.

    Args:
        slip_at: the fraction of the way at which the fingers lose their force (a disturbance).
    """

    def skill(attempt: Attempt) -> None:
        check_finite("slip_at", slip_at or 0.0)
        cell.pose(target)
        snapshot = attempt.observe()
        if snapshot.held == target:
            raise UnsuitableHand(Reason.TARGET_IN_HAND, f"'{target}' is in the hand", name=target)
        attempt.go_above(snapshot, _approaches_over(attempt, snapshot, target), slip_at)

    return _perform(cell, seed, skill)


def move_above_free_place(
    cell: Workcell, seed: int, slip_at: float | None = None, region: Region | None = None
) -> Motion:
    """The tool to 10 cm above the clearest free place of the table within the region.

    Args:
        region: the arm's own workspace where none is given.
    """

    def skill(attempt: Attempt) -> None:
        among = region or workspace_of(cell.robot).region
        check_finite("the region", *among[0], *among[1], slip_at or 0.0)
        snapshot = attempt.observe()
        places = _free_places(attempt, snapshot, among)
        attempt.go_above(snapshot, _approaches_over_places(attempt, snapshot, places), slip_at)

    return _perform(cell, seed, skill)


def move_above_places(
    cell: Workcell,
    places: list[tuple[float, float]],
    height: float,
    seed: int,
    slip_at: float | None = None,
) -> Motion:
    """The tool to 10 cm above the first of these places that what is held can be put down to.

    Args:
        places: of a support, world frame, the most welcome first [m].
        height: of that support's top [m].
    """

    def skill(attempt: Attempt) -> None:
        if not places:
            raise NoPlaceFound(Reason.NO_FREE_PLACE, "there is no free place of that size")
        check_finite("a place", *(number for place in places for number in place), height, slip_at or 0.0)
        snapshot = attempt.observe()
        attempt.go_above(snapshot, _approaches_over_places(attempt, snapshot, places, height), slip_at)

    return _perform(cell, seed, skill)


def move_above_place(
    cell: Workcell, x: float, y: float, seed: int, slip_at: float | None = None, height: float = 0.0
) -> Motion:
    """The tool to 10 cm above a place [m, world frame]; what is held is then over it.

    A box whose sides differ is turned back along the axes, as it was declared, if the arm can.

    Args:
        height: of what is below, where that is not the table [m].
    """

    def skill(attempt: Attempt) -> None:
        check_finite("the place", x, y, slip_at or 0.0, height)
        snapshot = attempt.observe()
        approaches = _approaches_over_places(attempt, snapshot, [(x, y)], height, as_declared=True)
        attempt.go_above(snapshot, approaches, slip_at)

    return _perform(cell, seed, skill)


def grasp(cell: Workcell, target: str, seed: int) -> Motion:
    """Straight down, close, and straight up with the body; verified by finger width and pose."""

    def skill(attempt: Attempt) -> None:
        cell.pose(target)
        snapshot = attempt.observe()
        if snapshot.held is not None:
            raise UnsuitableHand(Reason.HAND_FULL, f"the hand holds '{snapshot.held}'", held=snapshot.held)
        if not still_above(snapshot, target, attempt.shape(target)):
            raise KinematicsError(Reason.NOT_ABOVE, f"the tool is not above '{target}'")
        approach = attempt.approach_from_here(snapshot, target)
        if approach is None:
            snapshot, approach = pushing.approach_anew(attempt, target)
        attempt.solved_by(differential_ik.SOLVER)
        attempt.take(snapshot, target, approach)

    return _perform(cell, seed, skill)


def release(cell: Workcell, seed: int) -> Motion:
    """Straight down until the held body rests on what is below, open, straight up.

    Over a container it is dropped inside, from as deep as the hand can go. An empty hand just opens.
    """

    def skill(attempt: Attempt) -> None:
        snapshot = attempt.observe()
        if snapshot.held is None:
            attempt.open_wide()
        else:
            releasing.release(attempt, snapshot, snapshot.held)

    return _perform(cell, seed, skill)


def open_hand(cell: Workcell, seed: int) -> Motion:
    """The fingers as wide as they go, where the hand is: what is held falls."""

    def skill(attempt: Attempt) -> None:
        attempt.open_wide()

    return _perform(cell, seed, skill)


def lift(cell: Workcell, height: float, seed: int) -> Motion:
    """Straight up by a height [m], with or without something in the hand."""

    def skill(attempt: Attempt) -> None:
        check_finite("the height", height)
        attempt.lift(attempt.observe(), height)

    return _perform(cell, seed, skill)


def push(cell: Workcell, target: str, direction: tuple[float, float], distance: float, seed: int) -> Motion:
    """Move a body over the table with the fingertips, by a distance [m] along x and y of the world."""

    def skill(attempt: Attempt) -> None:
        cell.pose(target)
        length = math.hypot(*direction)
        if not (math.isfinite(length + distance) and length > 0 and distance > 0):
            raise KinematicsError(Reason.UNUSABLE_POSE, f"no push: {distance} m towards {direction}")
        snapshot = attempt.observe()
        if snapshot.held is not None:
            raise UnsuitableHand(Reason.HAND_FULL, f"the hand holds '{snapshot.held}'", held=snapshot.held)
        pushing.push(attempt, snapshot, target, distance / length * np.array([*direction, 0.0]))

    return _perform(cell, seed, skill)


@cache
def _arm(robot: Robot) -> Arm:
    """Return the solvers of a robot, one set a process; `Arm.observe` renews what they hold of a cell."""
    return Arm(robot)


def _perform(cell: Workcell, seed: int, skill: Callable[[Attempt], None]) -> Motion:
    """Run a skill, with the clocks around it; failures become reasons."""
    attempt = Attempt(cell, _arm(cell.robot), seed % 2**32)
    cell.is_told_to_stop = False
    failure: KinematicsError | None = None
    started, simulated = time.perf_counter(), cell.time
    stepping, watching = cell.stepping_seconds, cell.watching_seconds
    try:
        skill(attempt)
    except KinematicsError as found:
        failure = found
        attempt.evidence.update(found.evidence, message=str(found))
    moving = cell.stepping_seconds - stepping
    elapsed = time.perf_counter() - started - (cell.watching_seconds - watching)
    return Motion(
        achieved=failure is None,
        reason=None if failure is None else failure.reason,
        evidence=attempt.evidence,
        planning_seconds=elapsed - moving,
        moving_seconds=moving,
        simulated_seconds=cell.time - simulated,
        solver="+".join(attempt.solvers),
        planner=attempt.planner,
    )


def _approaches_over(attempt: Attempt, snapshot: CellSnapshot, target: str) -> Iterator[Approach]:
    """To grasps of the target, or to places for what is held on top of it."""
    arm, shape = attempt.arm, attempt.shape(target)
    pose = snapshot.poses[target]
    if snapshot.held is None:
        _check_width(attempt, target, least_width(pose, shape))
        return grasp_approaches(arm, snapshot, target, shape, attempt.seed)
    held_shape = attempt.shape(snapshot.held)
    if containers.takes(shape, pose, held_shape):
        others = [
            other.position for name, other in snapshot.poses.items() if name not in (target, snapshot.held)
        ]
        over = containers.spots(shape, pose, held_shape, others)[:PLACES]
        return drop_approaches(
            arm, snapshot, held_shape, over, containers.rim_height(shape, pose), attempt.seed
        )
    tilt = tilt_of(snapshot, target, shape)
    if tilt > TILTED:
        raise Obstructed(Reason.SUPPORT_TILTED, f"'{target}' is tilted: nothing can stand on it", tilt=tilt)
    x, y, _ = pose.position
    yaw = yaw_of(rotation_from_quaternion(pose.quaternion_xyzw))
    if attempt.cell.bodies[target].is_fixed and min(half_extents_of(shape)[:2]) > ROOMY:
        places = _places_on(attempt, snapshot, target)
        return _approaches_over_places(attempt, snapshot, places, height_above(shape, pose))
    place = (x, y, height_above(shape, pose))
    return placement_approaches(arm, snapshot, held_shape, place, [yaw], attempt.seed)


def _check_width(attempt: Attempt, target: str, width: float) -> None:
    """Nothing helps where the hand does not open wide enough; what does not move is not for grasping."""
    most = greatest_width(attempt.arm.gripper)
    if most < width < math.inf and not attempt.cell.bodies[target].is_fixed:
        message = (
            f"'{target}' is {1000 * width:.0f} mm wide where it is narrowest, and the hand gets around "
            f"{1000 * most:.0f} mm"
        )
        raise UnsuitableHand(Reason.NO_GRASP, message, name=target, width=width, most=most)


def _approaches_over_places(
    attempt: Attempt,
    snapshot: CellSnapshot,
    places: list[tuple[float, float]],
    height: float = 0.0,
    as_declared: bool = False,
) -> Iterator[Approach]:
    """To the first places that the held body, or the empty hand, can be put down to, at a height [m]."""
    arm, seed = attempt.arm, attempt.seed
    for x, y in places[:PLACES]:
        if snapshot.held is None:
            above = global_ik.usual_tool(x, y, height + CLEARANCE)
            for q in arm.solutions(above, snapshot.q, snapshot.state, seed, restarts=2):
                yield Approach(q, q[None], snapshot.opening)
        else:
            yaws, shape = [yaw_of(snapshot.tool[:3, :3]), 0.0], attempt.shape(snapshot.held)
            found = placement_approaches(arm, snapshot, shape, (x, y, height), yaws, seed, as_declared)
            yield from (approach for approach in found if approach.is_free)


def _places_on(attempt: Attempt, snapshot: CellSnapshot, target: str) -> list[tuple[float, float]]:
    """Of a tray or shelf: the free ones, clearest first."""
    x, y, _ = snapshot.poses[target].position
    length, width, _ = half_extents_of(attempt.shape(target))
    spare = [max(0.0, half - EDGE) for half in (length, width)]
    region = ((x - spare[0], x + spare[0]), (y - spare[1], y + spare[1]))
    shapes = {name: attempt.shape(name) for name in snapshot.poses}
    others = {name: pose for name, pose in snapshot.poses.items() if name != target}
    places = free_places(others, shapes, str(snapshot.held), region)
    if not places:
        raise NoPlaceFound(Reason.NO_FREE_PLACE, f"'{target}' has no free place of that size")
    return places


def _free_places(attempt: Attempt, snapshot: CellSnapshot, region: Region) -> list[tuple[float, float]]:
    held = snapshot.held or ""
    shapes = {name: body.shape for name, body in attempt.cell.bodies.items()}
    places = free_places(snapshot.poses, {**shapes, "": _TOOL_SIZE}, held, region)
    attempt.evidence["free_places"] = len(places)
    if not places:
        raise NoPlaceFound(Reason.NO_FREE_PLACE, "the table has no free place of that size")
    return places
