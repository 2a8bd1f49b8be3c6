"""Bodies of a cell: shape, initial pose, mass and colour."""

import math
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from kinematics.errors import UnusableShape
from kinematics.geometry.transforms import UPRIGHT, Pose, Quaternion, Vector, check_pose
from kinematics.shapes.shapes import Box, Convex, Cylinder, Shape, Sphere, pieces_of, points_of

TABLE = "table"  # the name of the table among the bodies' names
PLAIN_FRICTION = 1.0
Colour: TypeAlias = tuple[float, float, float, float]  # red, green, blue, opacity, each 0..1


@dataclass(frozen=True)
class Body:
    """An object of the cell; with zero mass it is fixed, such as a bin, a tray or a shelf."""

    name: str
    shape: Shape
    position: Vector  # of the shape's origin, world frame [m]
    quaternion_xyzw: Quaternion = UPRIGHT
    mass: float = 0.1  # [kg]
    colour: Colour = (0.7, 0.7, 0.7, 1.0)
    friction: float = PLAIN_FRICTION  # coefficient against table and hand

    @property
    def pose(self) -> Pose:
        return Pose(self.position, self.quaternion_xyzw)

    @property
    def is_fixed(self) -> bool:
        return self.mass == 0.0


def check_body(body: Body) -> None:
    """Raise `UnusablePose`, or `UnusableShape` for no volume, or for an impossible mass or friction."""
    check_pose(body.name, body.pose)
    if not (math.isfinite(body.mass) and body.mass >= 0):
        raise UnusableShape(f"'{body.name}' needs a mass of zero or more, found {body.mass}")
    if not (math.isfinite(body.friction) and body.friction >= 0):
        raise UnusableShape(f"'{body.name}' needs a friction of zero or more, found {body.friction}")
    pieces = pieces_of(body.shape)
    if not pieces or not all(_has_volume(piece.shape) for piece in pieces):
        raise UnusableShape(f"'{body.name}' has a piece without volume, or none: {body.shape}")


def _has_volume(shape: Convex) -> bool:
    if isinstance(shape, Box):
        sizes = np.array(shape.half_extents)
    elif isinstance(shape, Cylinder):
        sizes = np.array([shape.radius, shape.height])
    elif isinstance(shape, Sphere):
        sizes = np.array([shape.radius])
    else:
        points = points_of(shape)
        if len(points) < 4 or not np.isfinite(points).all():
            return False
        sizes = np.linalg.svd(points - points.mean(axis=0), compute_uv=False)
    return bool(np.isfinite(sizes).all() and (sizes > 1e-6).all())
