"""Bins, trays and bowls: what is inside them, and where the next thing is best let go."""

import itertools
import math
from collections.abc import Iterable, Mapping

import numpy as np

from kinematics.geometry.transforms import Pose, Vector, rotation_from_quaternion
from kinematics.shapes.shapes import Cavity, Compound, Shape, reach_of

SPOTS = 5  # along each side of a cavity
FINGER_ROOM = 0.035  # between the middle of the hand and a wall, beside what it holds [m]
UPRIGHT = math.cos(math.radians(15))
_RISE = 0.02  # of a body's middle above the rim, at which it still lies in a heaped bin [m]


def cavity_of(shape: Shape) -> Cavity | None:
    return shape.cavity if isinstance(shape, Compound) else None


def takes(container: Shape, pose: Pose, item: Shape) -> bool:
    """Whether an item is dropped into this, rather than put on top of it."""
    cavity = cavity_of(container)
    is_upright = float(rotation_from_quaternion(pose.quaternion_xyzw)[2, 2]) > UPRIGHT
    return cavity is not None and is_upright and reach_of(item) < reach_of(container) - 1e-6


def is_inside(container: Shape, pose: Pose, position: Vector) -> bool:
    """Whether a point is in the hollow of a container, or heaped on what is there."""
    cavity = cavity_of(container)
    if cavity is None:
        return False
    x, y, z = _in_container(pose, position)
    within = abs(x) <= cavity.half_extents[0] and abs(y) <= cavity.half_extents[1]
    return within and cavity.floor - 1e-3 <= z <= cavity.rim + _RISE


def load_of(name: str, shapes: Mapping[str, Shape], poses: Mapping[str, Pose]) -> set[str]:
    """What lies in a container, upright or tilted, and goes along where it goes."""
    cavity = cavity_of(shapes[name])
    if cavity is None:
        return set()
    reach = reach_of(shapes[name])
    found = set()
    for other in shapes.keys() - {name}:
        x, y, z = _in_container(poses[name], poses[other].position)
        within = cavity_of(shapes[other]) is None and math.hypot(x, y) < reach
        if within and cavity.floor - 1e-3 <= z <= cavity.rim + _RISE:
            found.add(other)
    return found


def is_over(container: Shape, pose: Pose, position: Vector) -> bool:
    """Whether a point is above the hollow of a container, or in it."""
    cavity = cavity_of(container)
    if cavity is None:
        return False
    x, y, z = _in_container(pose, position)
    return abs(x) <= cavity.half_extents[0] and abs(y) <= cavity.half_extents[1] and z > cavity.floor


def rim_height(container: Shape, pose: Pose) -> float:
    """World height of the rim of an upright container [m]."""
    cavity = cavity_of(container)
    assert cavity is not None
    return pose.position[2] + cavity.rim


def spots(container: Shape, pose: Pose, item: Shape, others: Iterable[Vector]) -> list[tuple[float, float]]:
    """Where to let an item go, world frame [m]: farthest from what is in there, then nearest the middle."""
    cavity = cavity_of(container)
    assert cavity is not None
    room = min(reach_of(item), 0.03) + FINGER_ROOM
    spare = [max(0.0, half - room) for half in cavity.half_extents]
    rotation = rotation_from_quaternion(pose.quaternion_xyzw)
    inside = [other for other in others if is_inside(container, pose, other)]
    scored = []
    steps = [2 * k / (SPOTS - 1) - 1 for k in range(SPOTS)]
    for u, v in itertools.product(steps, steps):
        local = (u * spare[0], v * spare[1], 0.0)
        x, y = (float(pose.position[axis] + rotation[axis] @ local) for axis in (0, 1))
        near = min((math.hypot(x - ox, y - oy) for ox, oy, _ in inside), default=1.0)
        scored.append((-round(near, 3), round(math.hypot(*local[:2]), 6), x, y))
    return list(dict.fromkeys((x, y) for _, _, x, y in sorted(scored)))


def _in_container(pose: Pose, position: Vector) -> tuple[float, float, float]:
    rotation = rotation_from_quaternion(pose.quaternion_xyzw)
    x, y, z = (rotation.T @ np.subtract(position, pose.position)).tolist()
    return x, y, z
