"""Vectors, quaternions, and the extents of turned objects."""

from __future__ import annotations

from collections.abc import Iterable
from functools import lru_cache
from math import cos, isclose, sin, sqrt

Vector = tuple[float, float, float]  # [m], world frame: x ahead of the robot's base, z up
Quaternion = tuple[float, float, float, float]  # x, y, z, w, of length one; object to world

CLEARLY = 0.02  # difference of the two cosines by which a quarter turn is nearer than none

UNTURNED: Quaternion = (0.0, 0.0, 0.0, 1.0)


def moved(at: Vector, by: Iterable[float]) -> Vector:
    """Return a point after a shift [m]."""
    x, y, z = by
    return at[0] + float(x), at[1] + float(y), at[2] + float(z)


def about_vertical(yaw: float) -> Quaternion:
    """Return a turn about the world's z axis [rad]."""
    return 0.0, 0.0, sin(yaw / 2), cos(yaw / 2)


def turned_by(orientation: Quaternion, angle: float) -> Quaternion:
    """Return an orientation after a turn about the world's z axis [rad]."""
    x, y, z, w = orientation
    s, c = sin(angle / 2), cos(angle / 2)
    return c * x - s * y, c * y + s * x, c * z + s * w, c * w - s * z


def turned_about(middle: Vector, at: Vector, angle: float) -> Vector:
    """Return a point after a turn about the vertical through another [m] [rad]."""
    dx, dy = at[0] - middle[0], at[1] - middle[1]
    return middle[0] + cos(angle) * dx - sin(angle) * dy, middle[1] + sin(angle) * dx + cos(angle) * dy, at[2]


@lru_cache(4096)  # most objects lie as they lay a moment before
def extents_as_it_lies(size: Vector, orientation: Quaternion) -> Vector:
    """Return an object's extents along the world's axes, to the nearest quarter turn [m].

    About the vertical they are exchanged only where that is clearly nearer: an angle of 45 degrees is told
    in the same way however it is rounded.
    """
    x, y, z, w = orientation
    upward = (abs(2 * (x * z - w * y)), abs(2 * (y * z + w * x)), abs(1 - 2 * (x * x + y * y)))
    axis = upward.index(max(upward))
    along_x = (abs(1 - 2 * (y * y + z * z)), abs(2 * (x * y - w * z)), abs(2 * (x * z + w * y)))
    if axis == 2 and along_x[1] < along_x[0] + CLEARLY:
        return size
    first, second = sorted((each for each in range(3) if each != axis), key=lambda each: -along_x[each])
    return size[first], size[second], size[axis]


def orientation_with_extents(size: Vector, extents: Vector) -> Quaternion:
    """Return a turn after which an object has these extents. Raises `ValueError` where there is none."""
    for order, turn in _QUARTER_TURNS.items():
        lying = tuple(size[axis] for axis in order)
        if all(isclose(a, b, abs_tol=1e-4) for a, b in zip(lying, extents, strict=True)):
            return turn
    raise ValueError(f"an object of {size} cannot lie with the extents {extents}")


_HALF = sqrt(0.5)
# By which of its axes comes to lie along x, y and z.
_QUARTER_TURNS: dict[tuple[int, ...], Quaternion] = {
    (0, 1, 2): UNTURNED,
    (0, 2, 1): (_HALF, 0.0, 0.0, _HALF),
    (2, 1, 0): (0.0, _HALF, 0.0, _HALF),
    (1, 0, 2): (0.0, 0.0, _HALF, _HALF),
    (2, 0, 1): (0.5, 0.5, 0.5, 0.5),
    (1, 2, 0): (-0.5, -0.5, -0.5, 0.5),
}
