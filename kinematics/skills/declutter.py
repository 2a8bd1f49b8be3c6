"""From a body that no grasp fits to a push with the closed hand that sets it free of its
neighbours.
"""

import itertools
import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from kinematics.geometry.transforms import Array, Pose, rotation_from_quaternion, transform_from
from kinematics.shapes.bodies import Body
from kinematics.shapes.shapes import half_extents_of, height_above, height_below, support
from kinematics.skills.approach import CLEARANCE, TILTED, graspable, tilt_of
from kinematics.skills.arm import Arm, CellSnapshot

Bodies = Mapping[str, Body]

IN_THE_WAY = 0.03  # nearer than this, a body may be in the way of a finger [m]
TOUCHING = 0.006  # nearer than this, one body may rest on another [m]
RUN_UP = 0.008  # between the fingers and the body before the push [m]
ABOVE_TABLE = 0.012  # of the fingertips: higher, and the palm clears cubes beside the way [m]
DISTANCES = (0.03, 0.045, 0.06)  # that the body is pushed [m]
DIRECTIONS = 16
GRIP_FROM_TOP = 0.02  # of the fingertips below the top of a body that is to be toppled [m]
ROOM = 0.004  # that a pushed body keeps from the others [m]
HELD_BACK = 0.03  # of a push, for a second look [m]
SPREAD = 0.5  # of half a body's width: where two fingertips push it without turning it
FINGER_SPARE = 0.0017  # beyond the closed fingers' own size [m]


@dataclass(frozen=True)
class Nudge:
    """Joint positions of a push."""

    above: Array  # (dof,) [rad]
    down: Array  # (n, dof) from above to beside the body
    sweep: Array  # (m, dof) the push itself
    opening: float = 0.0  # of each finger meanwhile [m]


def nudges(arm: Arm, snapshot: CellSnapshot, target: str, bodies: Bodies, seed: int) -> Iterator[Nudge]:
    """Pushes of the target, or of what touches it, after which a grasp fits or more room is.

    Those after which a grasp fits come first, and of these the ones that push the target itself.
    """
    ranked = []
    for order, mover in enumerate([target, *_loose_neighbours(arm, snapshot, target, bodies)]):
        for k, distance in itertools.product(range(DIRECTIONS), DISTANCES):
            angle = 2 * math.pi * k / DIRECTIONS
            shift = distance * np.array([math.cos(angle), math.sin(angle), 0.0])
            if _has_room(arm, snapshot, mover, shift):
                frees = _frees(arm, snapshot, target, mover, bodies, shift)
                ranked.append(((not frees, order > 0, distance, order, k), mover, shift))
    for _, mover, shift in sorted(ranked, key=lambda entry: entry[0]):
        nudge = _nudge(arm, snapshot, mover, bodies[mover], shift, seed)
        if nudge is not None:
            yield nudge
    if tilt_of(snapshot, target, bodies[target].shape) > TILTED:
        yield from _topples(arm, snapshot, target, bodies, seed)


def asked_push(
    arm: Arm, snapshot: CellSnapshot, target: str, bodies: Bodies, shift: Array, seed: int
) -> Nudge | None:
    """The push of a body by that much, with both fingertips as far apart as the body carries [m].

    A part of the way is held back, since the body may turn against the fingers meanwhile. None where
    something is in the way of the hand, or of the body where it would go.
    """
    if not _has_room(arm, snapshot, target, shift):
        return None
    body, pose = bodies[target], snapshot.poses[target]
    across = np.array([-shift[1], shift[0], 0.0]) / float(np.linalg.norm(shift))
    rotation = rotation_from_quaternion(pose.quaternion_xyzw)
    half_width = min(support(body.shape, rotation.T @ across), support(body.shape, -rotation.T @ across))
    opening = min(SPREAD * half_width, arm.gripper.maximum_opening)
    distance = float(np.linalg.norm(shift))
    first = max(distance - HELD_BACK, distance / 2) / distance * shift
    for spread in (opening, 0.0):
        nudge = _nudge(arm, snapshot, target, body, first, seed, opening=spread)
        if nudge is not None:
            return nudge
    return None


def _topples(arm: Arm, snapshot: CellSnapshot, target: str, bodies: Bodies, seed: int) -> Iterator[Nudge]:
    """Pushes high up on a body that leans on others, towards where there is most room."""
    position = np.array(snapshot.poses[target].position)
    others = [np.array(pose.position) for name, pose in snapshot.poses.items() if name != target]

    def room(direction: Array) -> float:
        fallen = position + 0.09 * direction
        return min((float(np.hypot(*(fallen - other)[:2])) for other in others), default=1.0)

    angles = [2 * math.pi * k / DIRECTIONS for k in range(DIRECTIONS)]
    directions = [np.array([math.cos(angle), math.sin(angle), 0.0]) for angle in angles]
    tips = height_above(bodies[target].shape, snapshot.poses[target]) - GRIP_FROM_TOP
    for direction in sorted(directions, key=lambda d: -round(room(d), 4)):
        nudge = _nudge(arm, snapshot, target, bodies[target], 0.06 * direction, seed, tips)
        if nudge is not None:
            yield nudge


def _loose_neighbours(arm: Arm, snapshot: CellSnapshot, target: str, bodies: Bodies) -> list[str]:
    """What stands beside the target, in the way of a finger, and carries nothing."""
    height = snapshot.poses[target].position[2]
    return [
        name
        for name in bodies
        if name != target
        and not bodies[name].is_fixed
        and arm.scene.distance(name, target, snapshot.state) < IN_THE_WAY
        and abs(snapshot.poses[name].position[2] - height) < min(half_extents_of(bodies[name].shape))
        and not _carries(arm, snapshot, name, bodies)
    ]


def _carries(arm: Arm, snapshot: CellSnapshot, name: str, bodies: Bodies) -> bool:
    height = snapshot.poses[name].position[2] + min(half_extents_of(bodies[name].shape))
    return any(
        snapshot.poses[other].position[2] > height
        and arm.scene.distance(name, other, snapshot.state) < TOUCHING
        for other in bodies
        if other != name
    )


def _has_room(arm: Arm, snapshot: CellSnapshot, mover: str, shift: Array) -> bool:
    """Whether a body can be shifted without coming nearer to another than `ROOM`, or than it is."""
    now = arm.scene.room_of(mover, [np.zeros(3)], snapshot.state)
    on_the_way = arm.scene.room_of(mover, [shift * t for t in (0.3, 0.6, 1.0)], snapshot.state)
    return on_the_way >= min(ROOM, now - 3e-4)


def _frees(arm: Arm, snapshot: CellSnapshot, target: str, mover: str, bodies: Bodies, shift: Array) -> bool:
    """Whether a grasp would fit the target if the mover were shifted."""
    pose = snapshot.poses[mover]
    x, y, z = (np.array(pose.position) + shift).tolist()
    there = snapshot.state.moved(mover, Pose((x, y, z), pose.quaternion_xyzw))
    return graspable(arm, there, target, bodies[target].shape)


def _nudge(
    arm: Arm,
    snapshot: CellSnapshot,
    target: str,
    body: Body,
    shift: Array,
    seed: int,
    tips: float | None = None,
    opening: float = 0.0,
) -> Nudge | None:
    """The push, with the fingertips at a height, or just above what the body stands on."""
    pose = snapshot.poses[target]
    distance = float(np.linalg.norm(shift))
    direction = shift / distance
    rotation = rotation_from_quaternion(pose.quaternion_xyzw)
    radius = support(body.shape, -rotation.T @ direction)
    bottom = pose.position[2] - height_below(body.shape, rotation)
    tips = bottom + ABOVE_TABLE if tips is None else tips
    state = snapshot.state.with_opening(opening)
    for turn, half_size in zip((0.0, math.pi / 2), arm.gripper.half_sizes, strict=True):
        depth = half_size + FINGER_SPARE
        low = _hand_facing(direction, turn)
        low[:3, 3] = np.array(pose.position) - direction * (radius + depth + RUN_UP)
        low[2, 3] = tips + arm.gripper.beyond_tool(opening, opening)
        above, end = low.copy(), low.copy()
        above[2, 3] = height_above(body.shape, pose) + CLEARANCE
        end[:3, 3] += direction * (RUN_UP + distance)
        for q in arm.solutions(above, snapshot.q, state, seed, 2):
            down = arm.lines.follow(q, [low])
            if down is None or not arm.chain_is_free(down, state):
                continue
            sweep = arm.lines.follow(down[-1], [end])
            if sweep is not None and arm.chain_is_free(sweep, state.without(target)):
                return Nudge(q, down, sweep, opening)
    return None


def _hand_facing(direction: Array, turn: float) -> Array:
    """A hand that points straight down, its x along the direction, or turned from there."""
    angle = math.atan2(direction[1], direction[0]) + turn
    x = np.array([math.cos(angle), math.sin(angle), 0.0])
    y = np.array([math.sin(angle), -math.cos(angle), 0.0])
    return transform_from(np.array([x, y, [0.0, 0.0, -1.0]]).T, (0.0, 0.0, 0.0))
