"""Poses and rotations. Quaternions are xyzw; `wxyz` is the one place that reorders them."""

import math
from typing import NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from kinematics.errors import UnusablePose

Array: TypeAlias = NDArray[np.float64]
Vector: TypeAlias = tuple[float, float, float]
Quaternion: TypeAlias = tuple[float, float, float, float]

UPRIGHT: Quaternion = (0.0, 0.0, 0.0, 1.0)
Z_AXIS: Array = np.array([0.0, 0.0, 1.0])
ROTATION_TOLERANCE = 1e-3  # of a quaternion's length, and of a matrix's rows


class Pose(NamedTuple):
    """Position and orientation of a frame, in the world unless a name says otherwise."""

    position: Vector  # [m]
    quaternion_xyzw: Quaternion


def check_pose(name: str, pose: Pose) -> Pose:
    """Return the pose; raise `UnusablePose` if it is not finite, or its quaternion not of unit length."""
    numbers = (*pose.position, *pose.quaternion_xyzw)
    length = math.hypot(*pose.quaternion_xyzw)
    if not all(map(math.isfinite, numbers)) or abs(length - 1.0) > ROTATION_TOLERANCE:
        raise UnusablePose(name, pose)
    return pose


def check_finite(what: str, *numbers: float) -> None:
    """Raise `UnusablePose` if a number is not finite."""
    if not all(map(math.isfinite, numbers)):
        raise UnusablePose(what, numbers)


def check_transform(what: str, transform: Array) -> None:
    """Raise `UnusablePose` unless it is finite, and its rotation orthonormal with determinant 1.

    In plain floats, since every query of inverse kinematics pays for it: 1.3 microseconds.
    """
    try:
        (a, b, c, x), (d, e, f, y), (g, h, i, z), last = transform.tolist()
        deviation = _from_rotation(a, b, c, d, e, f, g, h, i) + 0.0 * (x + y + z)  # nan if not finite
    except (ValueError, TypeError):  # of another shape
        deviation, last = math.nan, []
    if not deviation < ROTATION_TOLERANCE or last != [0.0, 0.0, 0.0, 1.0]:
        raise UnusablePose(what, transform.tolist())


def check_rotation(what: str, rotation: Array) -> None:
    """Raise `UnusablePose` unless the matrix (3, 3) is a rotation."""
    if rotation.shape != (3, 3) or not _from_rotation(*rotation.ravel().tolist()) < ROTATION_TOLERANCE:
        raise UnusablePose(what, rotation.tolist())


def _from_rotation(
    a: float, b: float, c: float, d: float, e: float, f: float, g: float, h: float, i: float
) -> float:
    """Return a matrix's deviation from a rotation: unit rows, the last the product of the others."""
    return (
        abs(a * a + b * b + c * c - 1.0)
        + abs(d * d + e * e + f * f - 1.0)
        + abs(a * d + b * e + c * f)
        + abs(b * f - c * e - g)
        + abs(c * d - a * f - h)
        + abs(a * e - b * d - i)
    )


def wxyz(quaternion_xyzw: Quaternion) -> Quaternion:
    """Return the quaternion in the order of MuJoCo and mink."""
    x, y, z, w = quaternion_xyzw
    return (w, x, y, z)


def rotation_from_quaternion(quaternion_xyzw: Quaternion) -> Array:
    """Return the rotation matrix (3, 3)."""
    x, y, z, w = quaternion_xyzw
    scale = 2.0 / (x * x + y * y + z * z + w * w)
    return np.array(
        [
            [1 - scale * (y * y + z * z), scale * (x * y - z * w), scale * (x * z + y * w)],
            [scale * (x * y + z * w), 1 - scale * (x * x + z * z), scale * (y * z - x * w)],
            [scale * (x * z - y * w), scale * (y * z + x * w), 1 - scale * (x * x + y * y)],
        ]
    )


def quaternion_from_rotation(rotation: Array) -> Quaternion:
    """Return the quaternion; its largest component is computed first, which is stable for every rotation."""
    m = rotation.tolist()
    squares = (  # four times the square of x, y, z, w
        1 + m[0][0] - m[1][1] - m[2][2],
        1 - m[0][0] + m[1][1] - m[2][2],
        1 - m[0][0] - m[1][1] + m[2][2],
        1 + m[0][0] + m[1][1] + m[2][2],
    )
    largest = max(range(4), key=lambda i: squares[i])
    s = 0.5 / math.sqrt(squares[largest])
    if largest == 3:
        return (
            (m[2][1] - m[1][2]) * s,
            (m[0][2] - m[2][0]) * s,
            (m[1][0] - m[0][1]) * s,
            0.25 / s,
        )
    i, j, k = largest, (largest + 1) % 3, (largest + 2) % 3
    parts = [0.0, 0.0, 0.0]
    parts[i] = 0.25 / s
    parts[j] = (m[j][i] + m[i][j]) * s
    parts[k] = (m[k][i] + m[i][k]) * s
    return (parts[0], parts[1], parts[2], (m[k][j] - m[j][k]) * s)


def transform_from(rotation: Array, translation: Array | Vector) -> Array:
    """Return the homogeneous transform (4, 4)."""
    transform = np.eye(4)
    transform[:3, :3] = rotation
    transform[:3, 3] = translation
    return transform


def transform_of(pose: Pose) -> Array:
    """Return the transform of the frame to the world (4, 4)."""
    return transform_from(rotation_from_quaternion(pose.quaternion_xyzw), pose.position)


def pose_of(transform: Array) -> Pose:
    """Return the pose of a transform: the inverse of `transform_of`."""
    x, y, z = transform[:3, 3].tolist()
    return Pose((x, y, z), quaternion_from_rotation(transform[:3, :3]))


def inverse(transform: Array) -> Array:
    """Return the inverse transform (4, 4)."""
    rotation = transform[:3, :3].T
    return transform_from(rotation, -rotation @ transform[:3, 3])


def rotation_about(axis: Array, angle: float) -> Array:
    """Return the rotation by `angle` [rad] about a unit axis (Rodrigues)."""
    x, y, z = axis.tolist()
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]], dtype=float)
    turned: Array = np.eye(3) + math.sin(angle) * cross + (1 - math.cos(angle)) * (cross @ cross)
    return turned


def rotation_from_rpy(rpy: Array | Vector) -> Array:
    """Return the rotation of fixed-axis roll, pitch and yaw, as in URDF [rad]."""
    (cr, cp, cy), (sr, sp, sy) = np.cos(rpy).tolist(), np.sin(rpy).tolist()
    return np.array(
        [
            [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
            [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
            [-sp, cp * sr, cp * cr],
        ]
    )


def rpy_from_rotation(rotation: Array) -> Vector:
    """Return roll, pitch and yaw [rad]; roll is zero if pitch is a right angle."""
    pitch = math.atan2(-rotation[2, 0], math.hypot(rotation[0, 0], rotation[1, 0]))
    if abs(math.cos(pitch)) < 1e-9:
        return (0.0, pitch, math.atan2(-rotation[0, 1], rotation[1, 1]))
    roll = math.atan2(rotation[2, 1], rotation[2, 2])
    return (roll, pitch, math.atan2(rotation[1, 0], rotation[0, 0]))


def angle_between(a: Array, b: Array) -> float:
    """Return the angle of the rotation between two rotation matrices [rad]."""
    cosine = (float(np.sum(a * b)) - 1.0) / 2.0  # trace of a.T @ b
    return math.acos(min(1.0, max(-1.0, cosine)))
