"""What the cell holds: a shape, where it starts, how heavy it is and what it looks like."""

from dataclasses import dataclass
from typing import TypeAlias

from kinematics.geometry import UPRIGHT, Pose, Quaternion, Vector
from kinematics.shapes import Shape

Colour: TypeAlias = tuple[float, float, float, float]  # red, green, blue, opacity, each 0..1


@dataclass(frozen=True)
class Body:
    """A thing of the cell. Without a mass it never moves: bins, trays, shelves."""

    name: str
    shape: Shape
    position: Vector  # of the shape's origin, world frame [m]
    quaternion_xyzw: Quaternion = UPRIGHT
    mass: float = 0.1  # [kg]
    colour: Colour = (0.7, 0.7, 0.7, 1.0)

    @property
    def pose(self) -> Pose:
        return Pose(self.position, self.quaternion_xyzw)

    @property
    def is_fixed(self) -> bool:
        return self.mass == 0.0
