"""From a body that no grasp fits to pushes with the closed hand that unblock it."""

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
MAY_REST_ON = 0.006  # nearer than this, a body may rest on another [m]
RUN_UP = 0.008  # between the fingers and the body before the push [m]
TIP_HEIGHT = 0.012  # of the fingertips above the support; the palm clears cubes beside the way [m]
PALM_SPARE = 0.003  # between a pushed body's top and the palm, at least [m]
DISTANCES = (0.03, 0.045, 0.06)  # of pushes [m]
DIRECTIONS = 16
TOPPLING_DEPTH = 0.02  # of the fingertips below the top of a body that is to topple [m]
TOPPLING_DISTANCE = 0.06  # of such a push [m]
FALLEN = 0.09  # from a leaning body to where it lies after a fall [m]
SEPARATION = 0.004  # that a pushed body keeps from the others [m]
SEPARATION_LOSS = 3e-4  # of a body that is nearer to another already [m]
FIRST_PUSH_SHORT = 0.03  # by how much a first push falls short, to be corrected after a new observation [m]
SPREAD = 0.5  # of the fingertips, relative to half a body's width: they push it without turning it
FINGER_SPARE = 0.0017  # beyond the closed fingers' own size [m]


@dataclass(frozen=True)
class Push:
    """Joint positions of a push with the fingertips."""

    above: Array  # (dof,) [rad]
    down: Array  # (n, dof) from above to beside the body
    sweep: Array  # (m, dof) the push itself
    opening: float = 0.0  # of each finger meanwhile [m]


def unblocking_pushes(
    arm: Arm, snapshot: CellSnapshot, target: str, bodies: Bodies, seed: int
) -> Iterator[Push]:
    """Yield pushes of the target, or of a neighbour, that give it more room.

    Those after which a grasp fits come first, and among these the pushes of the target itself.
    """
    ranked = []
    for order, mover in enumerate([target, *_movable_neighbours(arm, snapshot, target, bodies)]):
        for k, distance in itertools.product(range(DIRECTIONS), DISTANCES):
            angle = 2 * math.pi * k / DIRECTIONS
            shift = distance * np.array([math.cos(angle), math.sin(angle), 0.0])
            if _has_room(arm, snapshot, mover, shift):
                fits = _unblocks(arm, snapshot, target, mover, bodies, shift)
                ranked.append(((not fits, order > 0, distance, order, k), mover, shift))
    for _, mover, shift in sorted(ranked, key=lambda entry: entry[0]):
        push = _push_along(arm, snapshot, mover, bodies[mover], shift, seed)
        if push is not None:
            yield push
    if tilt_of(snapshot, target, bodies[target].shape) > TILTED:
        yield from _toppling_pushes(arm, snapshot, target, bodies, seed)


def push_by(
    arm: Arm, snapshot: CellSnapshot, target: str, bodies: Bodies, shift: Array, seed: int
) -> Push | None:
    """Return the push of a body by a horizontal shift [m], the fingertips as far apart as its width allows.

    The push falls short, since the body may turn against the fingers meanwhile. None if something is in the
    way of the hand or of the body.
    """
    if not _has_room(arm, snapshot, target, shift):
        return None
    body, pose = bodies[target], snapshot.poses[target]
    across = np.array([-shift[1], shift[0], 0.0]) / float(np.linalg.norm(shift))
    rotation = rotation_from_quaternion(pose.quaternion_xyzw)
    half_width = min(support(body.shape, rotation.T @ across), support(body.shape, -rotation.T @ across))
    opening = min(SPREAD * half_width, arm.gripper.maximum_opening)
    distance = float(np.linalg.norm(shift))
    first = max(distance - FIRST_PUSH_SHORT, distance / 2) / distance * shift
    for spread in (opening, 0.0):
        push = _push_along(arm, snapshot, target, body, first, seed, opening=spread)
        if push is not None:
            return push
    return None


def _toppling_pushes(
    arm: Arm, snapshot: CellSnapshot, target: str, bodies: Bodies, seed: int
) -> Iterator[Push]:
    """Yield pushes high up on a body that leans on others, towards the most room first."""
    position = np.array(snapshot.poses[target].position)
    others = [np.array(pose.position) for name, pose in snapshot.poses.items() if name != target]

    def room(direction: Array) -> float:
        fallen = position + FALLEN * direction
        return min((float(np.hypot(*(fallen - other)[:2])) for other in others), default=1.0)

    angles = [2 * math.pi * k / DIRECTIONS for k in range(DIRECTIONS)]
    directions = [np.array([math.cos(angle), math.sin(angle), 0.0]) for angle in angles]
    tips = height_above(bodies[target].shape, snapshot.poses[target]) - TOPPLING_DEPTH
    for direction in sorted(directions, key=lambda d: -round(room(d), 4)):
        push = _push_along(arm, snapshot, target, bodies[target], TOPPLING_DISTANCE * direction, seed, tips)
        if push is not None:
            yield push


def _movable_neighbours(arm: Arm, snapshot: CellSnapshot, target: str, bodies: Bodies) -> list[str]:
    """Return the movable bodies beside the target, in the way of a finger, that carry nothing."""
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
        and arm.scene.distance(name, other, snapshot.state) < MAY_REST_ON
        for other in bodies
        if other != name
    )


def _has_room(arm: Arm, snapshot: CellSnapshot, mover: str, shift: Array) -> bool:
    """Return whether a body, if shifted, keeps `SEPARATION` from all others, or the distance it has now."""
    now = arm.scene.distance_to_others(mover, [np.zeros(3)], snapshot.state)
    on_the_way = arm.scene.distance_to_others(mover, [shift * t for t in (0.3, 0.6, 1.0)], snapshot.state)
    return on_the_way >= min(SEPARATION, now - SEPARATION_LOSS)


def _unblocks(
    arm: Arm, snapshot: CellSnapshot, target: str, mover: str, bodies: Bodies, shift: Array
) -> bool:
    """Return whether a grasp would fit the target if the mover were shifted."""
    pose = snapshot.poses[mover]
    x, y, z = (np.array(pose.position) + shift).tolist()
    shifted = snapshot.state.moved(mover, Pose((x, y, z), pose.quaternion_xyzw))
    return graspable(arm, shifted, target, bodies[target].shape)


def _push_along(
    arm: Arm,
    snapshot: CellSnapshot,
    target: str,
    body: Body,
    shift: Array,
    seed: int,
    tips: float | None = None,
    opening: float = 0.0,
) -> Push | None:
    """Return a free push of a body, the fingertips at a height or as low as keeps the palm above the body."""
    pose = snapshot.poses[target]
    distance = float(np.linalg.norm(shift))
    direction = shift / distance
    rotation = rotation_from_quaternion(pose.quaternion_xyzw)
    radius = support(body.shape, -rotation.T @ direction)
    bottom = pose.position[2] - height_below(body.shape, rotation)
    if tips is None:
        tips = max(bottom + TIP_HEIGHT, height_above(body.shape, pose) - arm.gripper.palm_depth + PALM_SPARE)
        if tips > bottom + max(TIP_HEIGHT, radius):  # with friction of about 1 it topples
            return None
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
                return Push(q, down, sweep, opening)
    return None


def _hand_facing(direction: Array, turn: float) -> Array:
    """Return a hand that points straight down, its x axis at an angle `turn` from the direction."""
    angle = math.atan2(direction[1], direction[0]) + turn
    x = np.array([math.cos(angle), math.sin(angle), 0.0])
    y = np.array([math.sin(angle), -math.cos(angle), 0.0])
    return transform_from(np.array([x, y, [0.0, 0.0, -1.0]]).T, (0.0, 0.0, 0.0))
