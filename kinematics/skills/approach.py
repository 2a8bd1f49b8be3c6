"""From a target to where the arm is to wait above it, such that the straight way down is feasible
and free.
"""

import itertools
import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from kinematics.collision.scene_state import SceneState
from kinematics.geometry.transforms import Array, Vector, rotation_from_quaternion
from kinematics.grasping.grasps import Grasp, grasps_by_trouble
from kinematics.grasping.placements import Placement, placements
from kinematics.shapes.shapes import Box, Hull, Shape, faces_of, height_above, reach_of
from kinematics.skills.arm import LINE_MARGIN, Arm, CellSnapshot, travel

CLEARANCE = 0.10  # of the tool above the top of the target [m]
HELD_CLEARANCE = 0.04  # of a long held body above it [m]
STAND_OFF = 0.05  # from here on a tilted hand moves along its own approach [m]
ABOVE_SUPPORT = 5e-4  # of the held body when it is let go [m]
TILTED = math.radians(8)  # more than this, and nothing can stand on a body
EQUAL = 1e-3  # that halves of sides may differ by and count as the same [m]
RESTARTS = 6  # of the inverse kinematics, where its first answers do not serve
PASSES = ((0, 0.0), (RESTARTS, 2.0), (0, math.inf))  # restarts, and up to which trouble of the grasps


@dataclass(frozen=True)
class Approach:
    """Joint positions above a target, and the straight line from there."""

    above: Array  # (dof,) [rad]
    line: Array  # (n, dof) from above to the end; only `above` itself where that is obstructed
    opening: float  # of each finger at the end of the line [m]
    grasp: Grasp | None = None  # at the end of the line, where it leads to one
    tilt: float = 0.0  # of the hand, where it leads to a placement [rad]

    @property
    def trouble(self) -> float:
        """How far it is from a plain one."""
        return self.tilt if self.grasp is None else self.grasp.trouble

    @property
    def is_free(self) -> bool:
        return len(self.line) > 1


def tilt_of(snapshot: CellSnapshot, name: str, shape: Shape) -> float:
    """Of a body against the nearest way of having a level top [rad]."""
    up = rotation_from_quaternion(snapshot.poses[name].quaternion_xyzw)[2]
    if isinstance(shape, Box):
        cosine = float(np.abs(up).max())
    elif isinstance(shape, Hull):
        cosine = max(float(up @ normal) for normal, _, _ in faces_of(shape))
    else:
        cosine = float(up[2])
    return math.acos(max(-1.0, min(1.0, cosine)))


def corners_of(grasp: Grasp) -> list[Array]:
    """Tool transforms through which a straight way to the grasp leads."""
    stand_off = grasp.tool.copy()
    stand_off[:3, 3] -= STAND_OFF * grasp.tool[:3, 2]
    is_vertical = grasp.tool[2, 2] < -0.9999
    return [grasp.tool] if is_vertical else [stand_off, grasp.tool]


def grasp_approaches(
    arm: Arm, snapshot: CellSnapshot, target: str, shape: Shape, seed: int
) -> Iterator[Approach]:
    """Feasible approaches to grasps, plainest and nearest first; then those that are obstructed."""
    pose = snapshot.poses[target]
    height = height_above(shape, pose) + CLEARANCE
    for restarts, most_trouble in PASSES:
        for group in grasps_by_trouble(pose, shape, arm.gripper):
            if group[0].trouble > most_trouble:
                break
            ways = [
                (q, end, grasp)
                for grasp in group
                if _hand_fits(arm, snapshot.state, grasp)
                for end in _free_ends(arm, snapshot, grasp, seed, restarts)
                for q in _above_end(arm, snapshot.state, grasp, end, height)
            ]
            for q, end, grasp in sorted(ways, key=lambda way: travel(way[0], snapshot.q)):
                approach = line_to_grasp(arm, snapshot.state, q, grasp, end)
                if approach is not None:
                    yield approach
    for grasp in next(grasps_by_trouble(pose, shape, arm.gripper), []):
        for q in arm.solutions(_above(grasp, height), snapshot.q, snapshot.state, seed, RESTARTS):
            yield Approach(q, q[None], arm.gripper.maximum_opening, grasp)


def graspable(arm: Arm, state: SceneState, target: str, shape: Shape) -> bool:
    """Return whether the hand alone would be free in some nearly plain grasp of the body."""
    for group in grasps_by_trouble(state.poses[target], shape, arm.gripper):
        if any(_hand_fits(arm, state, grasp) for grasp in group if grasp.trouble <= 1.0):
            return True
        if group[0].trouble > 1.0:
            return False
    return False


def _hand_fits(arm: Arm, state: SceneState, grasp: Grasp) -> bool:
    return arm.scene.hand_is_free(grasp.tool, state.with_opening(grasp.openings[-1]), LINE_MARGIN)


def _free_ends(arm: Arm, snapshot: CellSnapshot, grasp: Grasp, seed: int, restarts: int) -> Iterator[Array]:
    """Joint positions at the grasp that are free with the narrowest opening of the fingers."""
    narrow = snapshot.state.with_opening(grasp.openings[-1])
    starts = arm.inverse.starts(grasp.tool, snapshot.q, seed, restarts)
    for q in arm.inverse.solutions(grasp.tool, starts):
        if arm.scene.is_free(q, narrow, LINE_MARGIN):
            yield q


def _above_end(arm: Arm, state: SceneState, grasp: Grasp, end: Array, height: float) -> Iterator[Array]:
    """Joint positions above the target, of the same branch as those at the grasp."""
    q = arm.inverse.solve(_above(grasp, height), end)
    if q is not None and arm.scene.is_free(q, state.with_opening(grasp.openings[-1])):
        yield q


def line_to_grasp(arm: Arm, state: SceneState, above: Array, grasp: Grasp, end: Array) -> Approach | None:
    """The straight line to a grasp with the widest opening of the fingers that stays free."""
    line: Array | None = None
    for opening in grasp.openings:
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
    """Feasible approaches for standing the held body on a point, least tilted first; then
    obstructed ones.

    Args:
        as_declared: of a box whose sides differ, first those in which its x axis is along the world's.
    """
    assert snapshot.held is not None
    tool_to_body = snapshot.body_to_tool(snapshot.held)
    options = [p for yaw in yaws for p in placements(tool_to_body, shape, snapshot.tool[:3, :3], yaw)]
    turned = as_declared and isinstance(shape, Box) and float(np.ptp(shape.half_extents)) > EQUAL

    def order(placement: Placement) -> tuple[float, float]:
        off = 1 - abs(float(placement.body_rotation[0, 0])) if turned else 0.0
        return round(placement.tilt, 1), round(off, 1)

    if turned:
        options.sort(key=order)
    for restarts in (0, RESTARTS):
        waiting: list[Approach] = []
        for _, group in itertools.groupby(options, key=order):
            reached = [
                (q, placement)
                for placement in group
                for q in _solutions_over(arm, snapshot, placement, place, seed, restarts)
            ]
            for q, placement in sorted(reached, key=lambda pair: travel(pair[0], snapshot.q)):
                approach = _line_to_placement(arm, snapshot, q, placement, place)
                if approach.is_free:
                    yield approach
                waiting.append(approach)
        if restarts:
            yield from waiting


def drop_approaches(
    arm: Arm, snapshot: CellSnapshot, shape: Shape, spots: list[tuple[float, float]], rim: float, seed: int
) -> Iterator[Approach]:
    """Approaches for letting the held body fall into a container, by spots in their order; last those
    from which no straight line leads down to the rim.
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
    """Of each finger when it lets go of a body as wide as that, widest first [m]."""
    half = width / 2
    return [min(widest, half + room) for room in (0.012, 0.008, 0.005)]


def opening_that_is_free(arm: Arm, state: SceneState, line: Array, width: float) -> float | None:
    """Return the widest opening of the hand, once it has let go, that keeps the margin along a line."""
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
    low = placement.tool_over(place[0], place[1], place[2] + placement.height + ABOVE_SUPPORT)
    line = arm.lines.follow(above, [low])
    if line is None:
        return obstructed
    if not arm.chain_is_free(line[:-1], snapshot.state):
        return obstructed
    opening = opening_that_is_free(arm, snapshot.state, line, 2 * snapshot.opening)
    return obstructed if opening is None else Approach(above, line, opening, tilt=placement.tilt)


def still_above(snapshot: CellSnapshot, target: str, shape: Shape) -> bool:
    """Whether the tool is over the target, near enough to go down from here."""
    pose = snapshot.poses[target]
    x, y, z = pose.position
    sideways = float(np.hypot(snapshot.tool[0, 3] - x, snapshot.tool[1, 3] - y))
    low = z + 0.05 if isinstance(shape, Box) else height_above(shape, pose)
    return sideways < STAND_OFF + max(0.0, reach_of(shape) - 0.04) and snapshot.tool[2, 3] > low
