"""Shapes of bodies, made of convex pieces for planner, simulator and camera.

In its own frame a shape is upright, with z up as it is usually put down.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from typing import TypeAlias

import numpy as np

from kinematics.geometry.transforms import UPRIGHT, Array, Pose, Quaternion, Vector, rotation_from_quaternion


@dataclass(frozen=True)
class Box:
    """A cuboid about its centre."""

    half_extents: Vector  # [m]


@dataclass(frozen=True)
class Cylinder:
    """A cylinder about its centre, along z."""

    radius: float  # [m]
    height: float  # [m]


@dataclass(frozen=True)
class Sphere:
    """A sphere about its centre."""

    radius: float  # [m]


@dataclass(frozen=True)
class Hull:
    """The convex hull of points; their frame's origin is the centre of mass."""

    points: tuple[Vector, ...]  # [m]


Convex: TypeAlias = Box | Cylinder | Sphere | Hull


@dataclass(frozen=True)
class Piece:
    """A convex part of a compound."""

    shape: Convex
    position: Vector = (0.0, 0.0, 0.0)  # of its centre in the compound's frame [m]
    quaternion_xyzw: Quaternion = UPRIGHT


@dataclass(frozen=True)
class Cavity:
    """The upright hollow of a container."""

    half_extents: tuple[float, float]  # along x and y, of the largest box that fits [m]
    floor: float  # above the compound's origin [m]
    rim: float  # above the compound's origin [m]


@dataclass(frozen=True)
class Compound:
    """Several convex pieces in one frame."""

    pieces: tuple[Piece, ...]
    handles: tuple[int, ...] = ()  # indices of the pieces that a hand may grip; empty for all
    cavity: Cavity | None = None


Shape: TypeAlias = Convex | Compound


def pieces_of(shape: Shape) -> tuple[Piece, ...]:
    """Return the convex pieces of any shape."""
    return shape.pieces if isinstance(shape, Compound) else (Piece(shape),)


def handles_of(shape: Shape) -> Iterator[Piece]:
    """Return an iterator over the pieces that a hand may grip."""
    pieces = pieces_of(shape)
    chosen = shape.handles if isinstance(shape, Compound) else ()
    return iter([pieces[k] for k in chosen] if chosen else pieces)


def support(shape: Shape, direction: Array) -> float:
    """Return how far the shape extends from its origin along a unit direction of its own frame [m]."""
    if isinstance(shape, Box):
        return float(np.abs(direction) @ np.asarray(shape.half_extents))
    if isinstance(shape, Cylinder):
        x, y, z = (float(part) for part in direction)
        return shape.radius * math.hypot(x, y) + shape.height / 2 * abs(z)
    if isinstance(shape, Sphere):
        return shape.radius
    if isinstance(shape, Hull):
        return float((points_of(shape) @ direction).max())
    return max(_piece_support(piece, direction) for piece in shape.pieces)


def _piece_support(piece: Piece, direction: Array) -> float:
    rotation = rotation_from_quaternion(piece.quaternion_xyzw)
    return float(np.dot(piece.position, direction)) + support(piece.shape, rotation.T @ direction)


@cache
def half_extents_of(shape: Shape) -> Vector:
    """Return the half extents of the box about the origin that encloses the shape [m]."""
    x, y, z = (max(support(shape, axis), support(shape, -axis)) for axis in np.eye(3))
    return (x, y, z)


@cache
def reach_of(shape: Shape) -> float:
    """Return the radius of the vertical cylinder about the origin that encloses the shape [m]."""
    if isinstance(shape, Box):
        return math.hypot(*shape.half_extents[:2])
    angles = np.linspace(0, 2 * math.pi, 32, endpoint=False)
    return max(support(shape, np.array([math.cos(a), math.sin(a), 0.0])) for a in angles)


@cache
def volume_of(shape: Convex) -> float:
    """Return the volume of a convex shape [m3]."""
    if isinstance(shape, Box):
        return 8.0 * math.prod(shape.half_extents)
    if isinstance(shape, Cylinder):
        return math.pi * shape.radius**2 * shape.height
    if isinstance(shape, Sphere):
        return 4.0 / 3.0 * math.pi * shape.radius**3
    from scipy.spatial import ConvexHull

    return float(ConvexHull(points_of(shape)).volume)


def height_above(shape: Shape, pose: Pose) -> float:
    """Return the height of a body's highest point, world frame [m]."""
    return pose.position[2] + support(shape, rotation_from_quaternion(pose.quaternion_xyzw)[2])


def height_below(shape: Shape, rotation: Array) -> float:
    """Return how far a rotated shape extends below its origin [m]."""
    return support(shape, -rotation[2])


@cache
def points_of(hull: Hull) -> Array:
    """Return the points of a hull (n, 3) [m]."""
    return np.array(hull.points)


@cache
def faces_of(hull: Hull) -> tuple[tuple[Vector, float, Vector], ...]:
    """Return outward normal, distance from the origin [m] and centre [m] of every face, largest first."""
    from scipy.spatial import ConvexHull

    points = points_of(hull)
    found = ConvexHull(points)
    merged: dict[tuple[float, ...], list[int]] = {}
    for k, plane in enumerate(found.equations):
        merged.setdefault(tuple(np.round(plane, 4)), []).append(k)
    faces = []
    for members in merged.values():
        triangles = points[found.simplices[members]]  # (m, 3, 3)
        areas = np.linalg.norm(
            np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0]), axis=1
        )
        centre = (triangles.mean(axis=1) * areas[:, None]).sum(axis=0) / areas.sum()
        x, y, z, offset = found.equations[members[0]].tolist()
        faces.append((float(areas.sum()), ((x, y, z), -offset, tuple(centre.tolist()))))
    return tuple(face for _, face in sorted(faces, key=lambda entry: -entry[0]))
