"""From a shape to the pairs of opposite surfaces that two fingers can close on."""

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from kinematics.geometry.transforms import (
    Z_AXIS,
    Array,
    Pose,
    pose_of,
    rotation_from_quaternion,
    transform_of,
)
from kinematics.shapes.shapes import (
    Box,
    Convex,
    Cylinder,
    Hull,
    Piece,
    Shape,
    Sphere,
    faces_of,
    handles_of,
    support,
)

YAWS = 8  # closing directions that are tried on a round body
WALL = 0.01  # a tall part that is thinner than this is gripped near its edge [m]
WALL_DEPTH = 0.013  # of the tool below that edge [m]
PARALLEL = math.cos(math.radians(10))  # two faces are a pair if they are at least as parallel as this
LARGEST_OFFSET = 0.012  # between the centres of two faces of a pair [m]
FRICTION_CONE = math.cos(math.radians(20))  # within which fingers hold by friction


@dataclass(frozen=True)
class ContactPair:
    """Two opposite surfaces of a body, in the world frame."""

    normal: Array  # (3,) unit, from one to the other
    centre: Array  # (3,) half-way between them [m]
    width: float  # between them [m]
    depth: float  # of the tool below the top of the piece, at most [m]
    piece: Convex
    piece_pose: Pose


def contact_pairs_of(shape: Shape, pose: Pose) -> Iterator[ContactPair]:
    """Yield the contact pairs of a body at a pose, only those on its handles if it has any."""
    for handle in handles_of(shape):
        yield from _pairs(handle.shape, _in_world(handle, pose))


def _in_world(piece: Piece, pose: Pose) -> Pose:
    return pose_of(transform_of(pose) @ transform_of(Pose(piece.position, piece.quaternion_xyzw)))


def _pairs(shape: Convex, pose: Pose) -> Iterator[ContactPair]:
    rotation, centre = rotation_from_quaternion(pose.quaternion_xyzw), np.array(pose.position)
    if isinstance(shape, Box):
        for axis, half in enumerate(shape.half_extents):
            is_wall = 2 * half < WALL < max(shape.half_extents[k] for k in range(3) if k != axis)
            depth = WALL_DEPTH if is_wall else math.inf
            yield ContactPair(rotation[:, axis], centre, 2 * half, depth, shape, pose)
    elif isinstance(shape, Sphere):
        for normal in _yaws():
            yield ContactPair(normal, centre, 2 * shape.radius, math.inf, shape, pose)
    elif isinstance(shape, Cylinder):
        for normal in _across(rotation[:, 2]):
            yield ContactPair(normal, centre, 2 * shape.radius, math.inf, shape, pose)
    else:
        yield from _hull_pairs(shape, pose, rotation, centre)


def _yaws() -> Iterator[Array]:
    for k in range(YAWS):
        angle = math.pi * k / YAWS
        yield np.array([math.cos(angle), math.sin(angle), 0.0])


def _across(axis: Array) -> Iterator[Array]:
    """Yield the most horizontal directions at right angles to a cylinder's axis."""
    if abs(float(axis[2])) > 0.95:
        for yaw in _yaws():
            level = yaw - axis * float(axis @ yaw)
            yield level / float(np.linalg.norm(level))
    else:
        level = np.cross(axis, Z_AXIS)
        yield level / float(np.linalg.norm(level))


def _hull_pairs(shape: Hull, pose: Pose, rotation: Array, centre: Array) -> Iterator[ContactPair]:
    """Yield pairs of parallel faces; if none is nearly horizontal, also sides that friction can hold."""
    found = False
    faces = [(np.array(n), d, np.array(c)) for n, d, c in faces_of(shape)[:24]]
    for k, (first, near, middle) in enumerate(faces):
        for second, far, other in faces[k + 1 :]:
            if float(first @ second) > -PARALLEL:
                continue
            between = middle - other
            sideways = between - first * float(first @ between)
            if float(np.linalg.norm(sideways)) > LARGEST_OFFSET:
                continue
            normal = rotation @ first
            found = found or abs(float(normal[2])) < 0.5
            at = centre + rotation @ ((middle + other) / 2)
            yield ContactPair(normal, at, near + far, math.inf, shape, pose)
    if not found:
        yield from _friction_pairs(shape, pose, rotation, centre)


def _friction_pairs(shape: Hull, pose: Pose, rotation: Array, centre: Array) -> Iterator[ContactPair]:
    """Yield pairs of sides within the friction cone, narrowest first."""
    points = np.array(shape.points) @ rotation.T
    options = []
    for normal in _yaws():
        along = points @ normal
        ends = [points[np.abs(along - limit) < 1e-3].mean(axis=0) for limit in (along.max(), along.min())]
        between = ends[0] - ends[1]
        if float(between @ normal) < FRICTION_CONE * float(np.linalg.norm(between)):
            continue
        width = support(shape, rotation.T @ normal) + support(shape, -rotation.T @ normal)
        middle = centre + (ends[0] + ends[1]) / 2
        options.append(ContactPair(normal, middle, width, math.inf, shape, pose))
    yield from sorted(options, key=lambda pair: pair.width)
