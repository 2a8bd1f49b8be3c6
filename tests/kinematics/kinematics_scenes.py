"""Cubes for the tests of the arm."""

import math

import numpy as np

from kinematics.bench.cells import HALF
from kinematics.shapes.bodies import Body
from kinematics.shapes.shapes import Box


def cube(name: str, x: float, y: float, z: float = HALF, yaw: float = 0.0) -> Body:
    """Return a cube of 5 cm, turned about the vertical [rad]."""
    quaternion = (0.0, 0.0, math.sin(yaw / 2), math.cos(yaw / 2))
    return Body(name, Box((HALF, HALF, HALF)), (x, y, z), quaternion)


def scattered(seed: int, count: int = 8) -> list[Body]:
    """Return cubes on a jittered grid of 0.1 m, at least 8 cm apart, at random yaws."""
    generator = np.random.default_rng(seed)
    cells = [(x, y) for x in (0.35, 0.45, 0.55, 0.65) for y in (-0.15, -0.05, 0.05, 0.15)]
    while True:
        chosen = [cells[i] for i in generator.permutation(len(cells))[:count]]
        centres = np.array(chosen) + generator.uniform(-0.03, 0.03, (count, 2))
        gaps = np.linalg.norm(centres[:, None] - centres[None], axis=2) + np.eye(count)
        if gaps.min() >= 0.08:
            yaws = generator.uniform(-math.pi, math.pi, count)
            return [cube(f"b{i}", *centres[i].tolist(), yaw=float(yaws[i])) for i in range(count)]
