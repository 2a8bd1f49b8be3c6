"""Skills of the arm, each from a cell and a seed to a `Motion`.

A skill observes, plans, moves and observes again. An impossible motion is a `Motion` with a reason, never
an exception, and a failure before the arm moves leaves the world as it was.
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
from kinematics.grasping.grasps import largest_graspable_width, narrowest_width
from kinematics.grasping.placements import free_places, yaw_of
from kinematics.ik import differential_ik, global_ik
from kinematics.robot.robot import Region, Robot
from kinematics.shapes import containers
from kinematics.shapes.shapes import Box, half_extents_of, height_above
from kinematics.simulation.cell import Cell
from kinematics.skills import pushing, releasing
from kinematics.skills.approach import (
    CLEARANCE,
    TILTED,
    Approach,
    drop_approaches,
    grasp_approaches,
    is_above,
    placement_approaches,
    tilt_of,
    turned_approaches,
)
from kinematics.skills.arm import Arm, CellSnapshot
from kinematics.skills.skill_execution import SkillExecution
from kinematics.skills.workspace import workspace_of

PLACES = 12  # that are tried
ROOMY = 0.06  # half extent beyond which a fixed body has room for several others [m]
EDGE = 0.03  # between the centre of a body and the edge of its support [m]
_EMPTY_HAND = Box((0.01, 0.01, 0.01))  # the space that an empty hand needs at a place [m]


@dataclass(frozen=True)
class Motion:
    """The result of a skill."""

    achieved: bool
    reason: Reason | None = None
    evidence: dict[str, Any] = field(default_factory=dict)
    planning_seconds: float = 0.0  # wall
    moving_seconds: float = 0.0  # wall
    simulated_seconds: float = 0.0
    solver: str = ""
    planner: str = ""


def move_above(cell: Cell, target: str, seed: int, slip_at: float | None = None) -> Motion:
    """Move the tool to 10 cm above the top of a body; a held body is centred over it and aligned.

    Args:
        slip_at: the fraction of the way at which the fingers lose their force (a disturbance).
    """

    def run(skill: SkillExecution) -> None:
        check_finite("slip_at", slip_at or 0.0)
        cell.pose(target)
        snapshot = skill.observe()
        if snapshot.held == target:
            raise UnsuitableHand(Reason.TARGET_IN_HAND, f"'{target}' is in the hand", name=target)
        skill.go_above(snapshot, _approaches_over(skill, snapshot, target), slip_at)

    return _perform(cell, seed, run)


def move_above_free_place(
    cell: Cell, seed: int, slip_at: float | None = None, region: Region | None = None
) -> Motion:
    """Move the tool to 10 cm above the clearest free place of the table.

    Args:
        region: where to look for a place, by default in the arm's workspace.
    """

    def run(skill: SkillExecution) -> None:
        among = region or workspace_of(cell.robot).region
        check_finite("the region", *among[0], *among[1], slip_at or 0.0)
        snapshot = skill.observe()
        places = _free_places(skill, snapshot, among)
        skill.go_above(snapshot, _approaches_over_places(skill, snapshot, places), slip_at)

    return _perform(cell, seed, run)


def move_above_places(
    cell: Cell,
    places: list[tuple[float, float]],
    height: float,
    seed: int,
    slip_at: float | None = None,
) -> Motion:
    """Move the tool to 10 cm above the first of these places at which the held body can be put down.

    Args:
        places: on a support, best first, world frame [m].
        height: of the support's top [m].
    """

    def run(skill: SkillExecution) -> None:
        if not places:
            raise NoPlaceFound(Reason.NO_FREE_PLACE, "there is no free place of that size")
        check_finite("a place", *(number for place in places for number in place), height, slip_at or 0.0)
        snapshot = skill.observe()
        skill.go_above(snapshot, _approaches_over_places(skill, snapshot, places, height), slip_at)

    return _perform(cell, seed, run)


def move_above_place(
    cell: Cell, x: float, y: float, seed: int, slip_at: float | None = None, height: float = 0.0
) -> Motion:
    """Move the tool to 10 cm above a place [m, world frame]; a held body is centred over it.

    A box whose sides differ is aligned with the axes, as it was declared, if the arm can.

    Args:
        height: of the support, if that is not the table [m].
    """

    def run(skill: SkillExecution) -> None:
        check_finite("the place", x, y, slip_at or 0.0, height)
        snapshot = skill.observe()
        approaches = _approaches_over_places(skill, snapshot, [(x, y)], height, as_declared=True)
        skill.go_above(snapshot, approaches, slip_at)

    return _perform(cell, seed, run)


def turn_held(cell: Cell, angle: float, seed: int, slip_at: float | None = None) -> Motion:
    """Turn the held body about the vertical through its middle, by an angle or a half turn less.

    Args:
        angle: seen from above, counter-clockwise [rad].
    """

    def run(skill: SkillExecution) -> None:
        check_finite("the angle", angle, slip_at or 0.0)
        snapshot = skill.observe()
        if snapshot.held is None:
            raise UnsuitableHand(Reason.HAND_CLOSED, "the hand holds nothing that could be turned")
        skill.go_above(snapshot, turned_approaches(skill.arm, snapshot, angle, skill.seed), slip_at)

    return _perform(cell, seed, run)


def grasp(cell: Cell, target: str, seed: int) -> Motion:
    """Go straight down, close, and lift the body; finger width and pose verify the grasp."""

    def run(skill: SkillExecution) -> None:
        cell.pose(target)
        snapshot = skill.observe()
        if snapshot.held is not None:
            raise UnsuitableHand(Reason.HAND_FULL, f"the hand holds '{snapshot.held}'", held=snapshot.held)
        if not is_above(snapshot, target, skill.shape(target)):
            raise KinematicsError(Reason.NOT_ABOVE, f"the tool is not above '{target}'")
        approach = skill.approach_from_here(snapshot, target)
        if approach is None:
            snapshot, approach = pushing.approach_anew(skill, target)
        skill.solved_by(differential_ik.SOLVER)
        skill.take(snapshot, target, approach)

    return _perform(cell, seed, run)


def release(cell: Cell, seed: int) -> Motion:
    """Go straight down until the held body rests on its support, open, and go up again.

    Over a container the body is dropped inside, from as deep as the hand can go. An empty hand just opens.
    """

    def run(skill: SkillExecution) -> None:
        snapshot = skill.observe()
        if snapshot.held is None:
            skill.open_wide()
        else:
            releasing.release(skill, snapshot, snapshot.held)

    return _perform(cell, seed, run)


def open_hand(cell: Cell, seed: int) -> Motion:
    """Open the fingers as wide as they go; a held body falls."""

    def run(skill: SkillExecution) -> None:
        skill.open_wide()

    return _perform(cell, seed, run)


def lift(cell: Cell, height: float, seed: int) -> Motion:
    """Lift the tool straight up by a height [m], with or without a held body."""

    def run(skill: SkillExecution) -> None:
        check_finite("the height", height)
        skill.lift(skill.observe(), height)

    return _perform(cell, seed, run)


def push(cell: Cell, target: str, direction: tuple[float, float], distance: float, seed: int) -> Motion:
    """Push a body over the table with the fingertips, by a distance [m] in a direction (x, y)."""

    def run(skill: SkillExecution) -> None:
        cell.pose(target)
        length = math.hypot(*direction)
        if not (math.isfinite(length + distance) and length > 0 and distance > 0):
            raise KinematicsError(Reason.UNUSABLE_POSE, f"no push: {distance} m towards {direction}")
        snapshot = skill.observe()
        if snapshot.held is not None:
            raise UnsuitableHand(Reason.HAND_FULL, f"the hand holds '{snapshot.held}'", held=snapshot.held)
        pushing.push(skill, snapshot, target, distance / length * np.array([*direction, 0.0]))

    return _perform(cell, seed, run)


@cache
def _arm(robot: Robot) -> Arm:
    """Return the solvers of a robot, one set a process; `Arm.observe` renews what they hold of a cell."""
    return Arm(robot)


def _perform(cell: Cell, seed: int, run: Callable[[SkillExecution], None]) -> Motion:
    """Run and time a skill; a `KinematicsError` becomes the motion's reason."""
    skill = SkillExecution(cell, _arm(cell.robot), seed % 2**32)
    cell.stop_requested = False
    failure: KinematicsError | None = None
    started, simulated = time.perf_counter(), cell.time
    stepping, frames = cell.stepping_seconds, cell.frame_seconds
    try:
        run(skill)
    except KinematicsError as found:
        failure = found
        skill.evidence.update(found.evidence, message=str(found))
    moving = cell.stepping_seconds - stepping
    elapsed = time.perf_counter() - started - (cell.frame_seconds - frames)
    return Motion(
        achieved=failure is None,
        reason=None if failure is None else failure.reason,
        evidence=skill.evidence,
        planning_seconds=elapsed - moving,
        moving_seconds=moving,
        simulated_seconds=cell.time - simulated,
        solver="+".join(skill.solvers),
        planner=skill.planner,
    )


def _approaches_over(skill: SkillExecution, snapshot: CellSnapshot, target: str) -> Iterator[Approach]:
    """Return approaches to grasps of the target, or to placements of the held body on it or in it."""
    arm, shape = skill.arm, skill.shape(target)
    pose = snapshot.poses[target]
    if snapshot.held is None:
        _check_width(skill, target, narrowest_width(pose, shape))
        return grasp_approaches(arm, snapshot, target, shape, skill.seed)
    held_shape = skill.shape(snapshot.held)
    if containers.accepts(shape, pose, held_shape):
        others = [
            other.position for name, other in snapshot.poses.items() if name not in (target, snapshot.held)
        ]
        over = containers.drop_spots(shape, pose, held_shape, others)[:PLACES]
        return drop_approaches(
            arm, snapshot, held_shape, over, containers.rim_height(shape, pose), skill.seed
        )
    tilt = tilt_of(snapshot, target, shape)
    if tilt > TILTED:
        raise Obstructed(Reason.SUPPORT_TILTED, f"'{target}' is tilted and supports nothing", tilt=tilt)
    x, y, _ = pose.position
    yaw = yaw_of(rotation_from_quaternion(pose.quaternion_xyzw))
    if skill.cell.bodies[target].is_fixed and min(half_extents_of(shape)[:2]) > ROOMY:
        places = _places_on(skill, snapshot, target)
        return _approaches_over_places(skill, snapshot, places, height_above(shape, pose))
    place = (x, y, height_above(shape, pose))
    return placement_approaches(arm, snapshot, held_shape, place, [yaw], skill.seed)


def _check_width(skill: SkillExecution, target: str, width: float) -> None:
    """Raise `UnsuitableHand` for a movable body that is too wide for the hand."""
    most = largest_graspable_width(skill.arm.gripper)
    if most < width < math.inf and not skill.cell.bodies[target].is_fixed:
        message = (
            f"'{target}' is {1000 * width:.0f} mm wide at its narrowest, and the hand opens for "
            f"{1000 * most:.0f} mm"
        )
        raise UnsuitableHand(Reason.NO_GRASP, message, name=target, width=width, most=most)


def _approaches_over_places(
    skill: SkillExecution,
    snapshot: CellSnapshot,
    places: list[tuple[float, float]],
    height: float = 0.0,
    as_declared: bool = False,
) -> Iterator[Approach]:
    """Yield approaches of the held body, or of the empty hand, to the first places, at a height [m]."""
    arm, seed = skill.arm, skill.seed
    for x, y in places[:PLACES]:
        if snapshot.held is None:
            above = global_ik.tool_pointing_down(x, y, height + CLEARANCE)
            for q in arm.solutions(above, snapshot.q, snapshot.state, seed, restarts=2):
                yield Approach(q, q[None], snapshot.opening)
        else:
            yaws, shape = [yaw_of(snapshot.tool[:3, :3]), 0.0], skill.shape(snapshot.held)
            found = placement_approaches(arm, snapshot, shape, (x, y, height), yaws, seed, as_declared)
            yield from (approach for approach in found if approach.is_free)


def _places_on(skill: SkillExecution, snapshot: CellSnapshot, target: str) -> list[tuple[float, float]]:
    """Return the free places on a tray or shelf, clearest first [m]."""
    x, y, _ = snapshot.poses[target].position
    length, width, _ = half_extents_of(skill.shape(target))
    spare = [max(0.0, half - EDGE) for half in (length, width)]
    region = ((x - spare[0], x + spare[0]), (y - spare[1], y + spare[1]))
    shapes = {name: skill.shape(name) for name in snapshot.poses}
    others = {name: pose for name, pose in snapshot.poses.items() if name != target}
    places = free_places(others, shapes, str(snapshot.held), region)
    if not places:
        raise NoPlaceFound(Reason.NO_FREE_PLACE, f"'{target}' has no free place of that size")
    return places


def _free_places(skill: SkillExecution, snapshot: CellSnapshot, region: Region) -> list[tuple[float, float]]:
    """Return the free places on the table, clearest first [m]."""
    held = snapshot.held or ""
    shapes = {name: body.shape for name, body in skill.cell.bodies.items()}
    places = free_places(snapshot.poses, {**shapes, "": _EMPTY_HAND}, held, region)
    skill.evidence["free_places"] = len(places)
    if not places:
        raise NoPlaceFound(Reason.NO_FREE_PLACE, "the table has no free place of that size")
    return places
