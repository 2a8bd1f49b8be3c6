"""The error of a camera: poses in, poses with seeded noise out."""

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from kinematics.geometry.transforms import (
    Z_AXIS,
    Pose,
    Vector,
    quaternion_from_rotation,
    rotation_about,
    rotation_from_quaternion,
)


@dataclass(frozen=True)
class Noise:
    """Standard deviations of observed poses; every observation draws anew."""

    position: float = 0.0  # along each of x, y and z [m]
    yaw: float = 0.0  # about the vertical [rad]

    def __post_init__(self) -> None:
        if not all(math.isfinite(sigma) and sigma >= 0 for sigma in (self.position, self.yaw)):
            raise ValueError(f"noise needs two numbers of zero or more, found {self}")

    def applied(self, poses: Mapping[str, Pose], generator: np.random.Generator) -> dict[str, Pose]:
        """Return the poses as one observation gives them."""
        return {name: self._applied(pose, generator) for name, pose in poses.items()}

    def _applied(self, pose: Pose, generator: np.random.Generator) -> Pose:
        x, y, z = (np.array(pose.position) + generator.normal(0, self.position, 3)).tolist()
        turn = rotation_about(Z_AXIS, float(generator.normal(0, self.yaw)))
        position: Vector = (x, y, z)
        return Pose(position, quaternion_from_rotation(turn @ rotation_from_quaternion(pose.quaternion_xyzw)))


NO_NOISE = Noise()
