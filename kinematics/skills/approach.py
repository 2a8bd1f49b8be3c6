"""From a target to joint positions above it from which the straight way down is feasible and free."""

import itertools
import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from kinematics.collision.scene_state import SceneState
from kinematics.geometry.transforms import (
    Z_AXIS,
    Array,
    Vector,
    rotation_about,
    rotation_from_quaternion,
    transform_from,
)
from kinematics.grasping.grasps import Grasp, grasps_by_cost
from kinematics.grasping.placements import Placement, placements
from kinematics.shapes.shapes import Box, Hull, Shape, faces_of, height_above, reach_of
from kinematics.skills.arm import LINE_MARGIN, Arm, CellSnapshot, largest_joint_change

CLEARANCE = 0.10  # of the tool above the top of the target [m]
HELD_CLEARANCE = 0.04  # of a long held body above the target [m]
STAND_OFF = 0.05  # within which a tilted hand moves along its own approach [m]
RELEASE_HEIGHT = 5e-4  # of the held body above its support when it is released [m]
RELEASE_ROOMS = (0.012, 0.008, 0.005)  # between body and each finger after a release, widest first [m]
TILTED = math.radians(8)  # beyond which a body supports nothing
EQUAL_EXTENTS = 1e-3  # half extents that differ by less count as equal [m]
RESTARTS = 6  # of inverse kinematics, if its first solutions do not serve
PASSES = ((0, 0.0), (RESTARTS, 2.0), (0, math.inf))  # restarts, and the largest cost of the grasps
PLAIN_ENOUGH = 1.0  # cost of a grasp that is worth a push


@dataclass(frozen=True)
class Approach:
    """Joint positions above a target, and the straight line from there."""

    above: Array  # (dof,) [rad]
    line: Array  # (n, dof) from above to the end; just `above` if the line is obstructed
    opening: float  # of each finger at the end of the line [m]
    grasp: Grasp | None = None  # at the end of the line, unless that is a placement
    tilt: float = 0.0  # of the hand at a placement [rad]

    @property
    def cost(self) -> float:
        """Deviation from a plain grasp, or tilt of a placement."""
        return self.tilt if self.grasp is None else self.grasp.cost

    @property
    def is_free(self) -> bool:
        """Whether the line leads all the way."""
        return len(self.line) > 1


def tilt_of(snapshot: CellSnapshot, name: str, shape: Shape) -> float:
    """Return the angle of a body to its nearest orientation with a level top [rad]."""
    up = rotation_from_quaternion(snapshot.poses[name].quaternion_xyzw)[2]
    if isinstance(shape, Box):
        cosine = float(np.abs(up).max())
    elif isinstance(shape, Hull):
        cosine = max(float(up @ normal) for normal, _, _ in faces_of(shape))
    else:
        cosine = float(up[2])
    return math.acos(max(-1.0, min(1.0, cosine)))


def corners_of(grasp: Grasp) -> list[Array]:
    """Return the tool transforms through which the straight way to a grasp leads."""
    stand_off = grasp.tool.copy()
    stand_off[:3, 3] -= STAND_OFF * grasp.tool[:3, 2]
    is_vertical = grasp.tool[2, 2] < -0.9999
    return [grasp.tool] if is_vertical else [stand_off, grasp.tool]


def grasp_approaches(
    arm: Arm, snapshot: CellSnapshot, target: str, shape: Shape, seed: int
) -> Iterator[Approach]:
    """Yield feasible approaches to grasps, cheapest and nearest first; then obstructed ones."""
    pose = snapshot.poses[target]
    height = height_above(shape, pose) + CLEARANCE
    for restarts, largest_cost in PASSES:
        for group in grasps_by_cost(pose, shape, arm.gripper):
            if group[0].cost > largest_cost:
                break
            ways = [
                (q, end, grasp)
                for grasp in group
                if _hand_fits(arm, snapshot.state, grasp)
                for end in _free_ends(arm, snapshot, grasp, seed, restarts)
                for q in _above_end(arm, snapshot.state, grasp, end, height)
            ]
            for q, end, grasp in sorted(ways, key=lambda way: largest_joint_change(way[0], snapshot.q)):
                approach = line_to_grasp(arm, snapshot.state, q, grasp, end)
                if approach is not None:
                    yield approach
    for grasp in next(grasps_by_cost(pose, shape, arm.gripper), []):
        for q in arm.solutions(_above(grasp, height), snapshot.q, snapshot.state, seed, RESTARTS):
            yield Approach(q, q[None], arm.gripper.maximum_opening, grasp)


def graspable(arm: Arm, state: SceneState, target: str, shape: Shape) -> bool:
    """Return whether the hand alone would be free in some nearly plain grasp of the body."""
    for group in grasps_by_cost(state.poses[target], shape, arm.gripper):
        if group[0].cost > PLAIN_ENOUGH:
            return False
        if any(_hand_fits(arm, state, grasp) for grasp in group):
            return True
    return False


def _hand_fits(arm: Arm, state: SceneState, grasp: Grasp) -> bool:
    return arm.scene.hand_is_free(grasp.tool, state.with_opening(grasp.openings[-1]), LINE_MARGIN)


def _closing_freely(arm: Arm, state: SceneState, grasp: Grasp) -> list[float]:
    """Return the openings, widest first, from which the fingers meet nothing but the body as they close.

    Wider ones may be free as well where a finger is beyond a wall that it would close on.
    """
    narrow_first = reversed(grasp.openings)
    free = itertools.takewhile(
        lambda opening: arm.scene.hand_is_free(grasp.tool, state.with_opening(opening), LINE_MARGIN),
        narrow_first,
    )
    return list(free)[::-1]


def _free_ends(arm: Arm, snapshot: CellSnapshot, grasp: Grasp, seed: int, restarts: int) -> Iterator[Array]:
    """Yield joint positions at the grasp that are free with the narrowest opening of the fingers."""
    narrow = snapshot.state.with_opening(grasp.openings[-1])
    starts = arm.inverse.starts(grasp.tool, snapshot.q, seed, restarts)
    for q in arm.inverse.solutions(grasp.tool, starts):
        if arm.scene.is_free(q, narrow, LINE_MARGIN):
            yield q


def _above_end(arm: Arm, state: SceneState, grasp: Grasp, end: Array, height: float) -> Iterator[Array]:
    """Yield joint positions above the target, on the same branch of solutions as those at the grasp."""
    q = arm.inverse.solve(_above(grasp, height), end)
    if q is not None and arm.scene.is_free(q, state.with_opening(grasp.openings[-1])):
        yield q


def line_to_grasp(arm: Arm, state: SceneState, above: Array, grasp: Grasp, end: Array) -> Approach | None:
    """Return the straight line to a grasp with the widest free opening from which the fingers can close."""
    line: Array | None = None
    for opening in _closing_freely(arm, state, grasp):
        opened = state.with_opening(opening)
        if not arm.scene.is_free(end, opened, LINE_MARGIN):
            continue
        if line is None:
            line = arm.lines.follow(above, corners_of(grasp))
        if line is None:
            return None
        if arm.chain_is_free(line, opened):
            return Approach(above, line, opening, grasp)
    return None


def placement_approaches(
    arm: Arm,
    snapshot: CellSnapshot,
    shape: Shape,
    place: Vector,
    yaws: list[float],
    seed: int,
    as_declared: bool = False,
) -> Iterator[Approach]:
    """Yield approaches that stand the held body on a point, least tilted first, then obstructed ones.

    Args:
        as_declared: for a box whose sides differ, those first that align its x axis with the world's.
    """
    assert snapshot.held is not None
    tool_to_body = snapshot.body_to_tool(snapshot.held)
    options = [p for yaw in yaws for p in placements(tool_to_body, shape, snapshot.tool[:3, :3], yaw)]
    aligned = as_declared and isinstance(shape, Box) and float(np.ptp(shape.half_extents)) > EQUAL_EXTENTS

    def order(placement: Placement) -> tuple[float, float]:
        misaligned = 1 - abs(float(placement.body_rotation[0, 0])) if aligned else 0.0
        return round(placement.tilt, 1), round(misaligned, 1)

    if aligned:
        options.sort(key=order)
    for restarts in (0, RESTARTS):
        waiting: list[Approach] = []
        for _, group in itertools.groupby(options, key=order):
            reached = [
                (q, placement)
                for placement in group
                for q in _solutions_over(arm, snapshot, placement, place, seed, restarts)
            ]
            for q, placement in sorted(reached, key=lambda pair: largest_joint_change(pair[0], snapshot.q)):
                approach = _line_to_placement(arm, snapshot, q, placement, place)
                if approach.is_free:
                    yield approach
                waiting.append(approach)
        if restarts:
            yield from waiting


def turned_approaches(arm: Arm, snapshot: CellSnapshot, angle: float, seed: int) -> Iterator[Approach]:
    """Yield the postures that turn the held body where it is, by an angle [rad] or a half turn less.

    The one with the smallest change of any joint comes first.
    """
    assert snapshot.held is not None
    centre = np.array(snapshot.poses[snapshot.held].position)
    found: list[Array] = []
    for turn in (angle, angle - math.copysign(math.pi, angle)):
        rotation = rotation_about(Z_AXIS, turn)
        place = centre + rotation @ (snapshot.tool[:3, 3] - centre)
        tool = transform_from(rotation @ snapshot.tool[:3, :3], place)
        found += arm.solutions(tool, snapshot.q, snapshot.state, seed, RESTARTS)
    for q in sorted(found, key=lambda q: largest_joint_change(q, snapshot.q)):
        yield Approach(q, q[None], snapshot.opening)


def drop_approaches(
    arm: Arm, snapshot: CellSnapshot, shape: Shape, spots: list[tuple[float, float]], rim: float, seed: int
) -> Iterator[Approach]:
    """Yield approaches that drop the held body into a container, in the order of the spots.

    Last come those from which no straight line leads down to the rim.
    """
    assert snapshot.held is not None
    options = placements(snapshot.body_to_tool(snapshot.held), shape, snapshot.tool[:3, :3], 0.0)
    stuck: list[Approach] = []
    for restarts in (0, RESTARTS):
        for x, y in spots:
            for placement in options:
                for q in _solutions_over(arm, snapshot, placement, (x, y, rim), seed, restarts):
                    line = arm.lines.follow(q, [placement.tool_over(x, y, rim)])
                    if line is not None:
                        yield Approach(q, line, snapshot.opening, tilt=placement.tilt)
                    else:
                        stuck.append(Approach(q, q[None], snapshot.opening, tilt=placement.tilt))
    yield from stuck


def release_openings(width: float, widest: float) -> list[float]:
    """Return openings of each finger for the release of a body, widest first [m]."""
    half = width / 2
    return [min(widest, half + room) for room in RELEASE_ROOMS]


def opening_that_is_free(arm: Arm, state: SceneState, line: Array, width: float) -> float | None:
    """Return the widest opening of the hand, after the release, that keeps the margin along a line [m]."""
    released = state.without_held()
    for opening in release_openings(width, arm.gripper.maximum_opening):
        if arm.chain_is_free(line, released.with_opening(opening)):
            return opening
    return None


def _above(grasp: Grasp, height: float) -> Array:
    above = grasp.tool.copy()
    above[:2, 3] = grasp.centre[:2]
    above[2, 3] = height
    return above


def _solutions_over(
    arm: Arm, snapshot: CellSnapshot, placement: Placement, place: Vector, seed: int, restarts: int
) -> Iterator[Array]:
    above = placement.tool_over(place[0], place[1], 0.0)
    below_tool = placement.height - float(placement.body_from_tool[2])  # of the body's lowest point [m]
    above[2, 3] = place[2] + max(CLEARANCE, below_tool + HELD_CLEARANCE)
    yield from arm.solutions(above, snapshot.q, snapshot.state, seed, restarts)


def _line_to_placement(
    arm: Arm, snapshot: CellSnapshot, above: Array, placement: Placement, place: Vector
) -> Approach:
    obstructed = Approach(above, above[None], snapshot.opening, tilt=placement.tilt)
    low = placement.tool_over(place[0], place[1], place[2] + placement.height + RELEASE_HEIGHT)
    line = arm.lines.follow(above, [low])
    if line is None:
        return obstructed
    if not arm.chain_is_free(line[:-1], snapshot.state):
        return obstructed
    opening = opening_that_is_free(arm, snapshot.state, line, 2 * snapshot.opening)
    return obstructed if opening is None else Approach(above, line, opening, tilt=placement.tilt)


def is_above(snapshot: CellSnapshot, target: str, shape: Shape) -> bool:
    """Return whether the tool is over the target, near enough to go down from here."""
    pose = snapshot.poses[target]
    x, y, z = pose.position
    sideways = float(np.hypot(snapshot.tool[0, 3] - x, snapshot.tool[1, 3] - y))
    low = z + 0.05 if isinstance(shape, Box) else height_above(shape, pose)
    return sideways < STAND_OFF + max(0.0, reach_of(shape) - 0.04) and snapshot.tool[2, 3] > low
