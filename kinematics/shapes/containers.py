"""Bins, trays and bowls: what is inside them, and where the next body is best dropped."""

import itertools
import math
from collections.abc import Iterable, Mapping

import numpy as np

from kinematics.geometry.transforms import Pose, Vector, rotation_from_quaternion
from kinematics.shapes.shapes import Cavity, Compound, Shape, reach_of

SPOTS = 5  # along each side of a cavity
HAND_ROOM = 0.035  # between a held body and a wall, for the hand [m]
UPRIGHT_COSINE = math.cos(math.radians(15))  # of a container that counts as upright
_HEAP = 0.02  # height of a body's centre above the rim up to which it is inside, in a heaped bin [m]


def cavity_of(shape: Shape) -> Cavity | None:
    """Return the cavity of a container, or None."""
    return shape.cavity if isinstance(shape, Compound) else None


def accepts(container: Shape, pose: Pose, item: Shape) -> bool:
    """Return whether an item is dropped into this shape, rather than put on top of it."""
    cavity = cavity_of(container)
    is_upright = float(rotation_from_quaternion(pose.quaternion_xyzw)[2, 2]) > UPRIGHT_COSINE
    return cavity is not None and is_upright and reach_of(item) < reach_of(container) - 1e-6


def is_inside(container: Shape, pose: Pose, position: Vector) -> bool:
    """Return whether a point is in the cavity of a container, or heaped on its contents."""
    cavity = cavity_of(container)
    if cavity is None:
        return False
    x, y, z = _in_container(pose, position)
    within = abs(x) <= cavity.half_extents[0] and abs(y) <= cavity.half_extents[1]
    return within and _is_at_height(cavity, z)


def contents_of(name: str, shapes: Mapping[str, Shape], poses: Mapping[str, Pose]) -> set[str]:
    """Return the bodies in a container, upright or tilted, which move with it."""
    cavity = cavity_of(shapes[name])
    if cavity is None:
        return set()
    reach = reach_of(shapes[name])
    found = set()
    for other in shapes.keys() - {name}:
        x, y, z = _in_container(poses[name], poses[other].position)
        within = cavity_of(shapes[other]) is None and math.hypot(x, y) < reach
        if within and _is_at_height(cavity, z):
            found.add(other)
    return found


def is_over(container: Shape, pose: Pose, position: Vector) -> bool:
    """Return whether a point is above the cavity of a container, or in it."""
    cavity = cavity_of(container)
    if cavity is None:
        return False
    x, y, z = _in_container(pose, position)
    return abs(x) <= cavity.half_extents[0] and abs(y) <= cavity.half_extents[1] and z > cavity.floor


def rim_height(container: Shape, pose: Pose) -> float:
    """Return the height of an upright container's rim, world frame [m]."""
    cavity = cavity_of(container)
    assert cavity is not None
    return pose.position[2] + cavity.rim


def drop_spots(
    container: Shape, pose: Pose, item: Shape, others: Iterable[Vector]
) -> list[tuple[float, float]]:
    """Return where to drop an item: far from the contents, then near the centre first, world frame [m]."""
    cavity = cavity_of(container)
    assert cavity is not None
    room = min(reach_of(item), 0.03) + HAND_ROOM
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


def _is_at_height(cavity: Cavity, z: float) -> bool:
    return cavity.floor - 1e-3 <= z <= cavity.rim + _HEAP


def _in_container(pose: Pose, position: Vector) -> tuple[float, float, float]:
    """Return a world position in the container's frame [m]."""
    rotation = rotation_from_quaternion(pose.quaternion_xyzw)
    x, y, z = (rotation.T @ np.subtract(position, pose.position)).tolist()
    return x, y, z
