"""Random cells for benchmarks: cubes on a jittered grid, a bin beside them, a pillar among them."""

import math

import numpy as np

from kinematics.robot.gripper import gripper_of
from kinematics.robot.robot import Robot
from kinematics.shapes.bodies import Body
from kinematics.shapes.catalogue import tub
from kinematics.shapes.shapes import Box
from kinematics.skills.workspace import workspace_of

HALF = 0.025  # half the edge of a cube, if the hand opens wide enough [m]
CUBE_FINGER_ROOM = 0.004  # between a cube and each finger, at least [m]
CUBES = 8  # of a cell
PITCH, JITTER = 0.1, 0.03  # of the grid [m]
SEPARATION = 0.08  # between centres, at least [m]
PILLAR = Box((0.025, 0.025, 0.16))
COLOURS = (
    (0.85, 0.2, 0.2, 1.0),
    (0.2, 0.65, 0.25, 1.0),
    (0.2, 0.35, 0.85, 1.0),
    (0.95, 0.8, 0.15, 1.0),
    (0.6, 0.25, 0.7, 1.0),
    (0.15, 0.7, 0.8, 1.0),
    (0.95, 0.5, 0.1, 1.0),
    (0.5, 0.35, 0.2, 1.0),
)


def _grid(robot: Robot) -> list[tuple[float, float]]:
    axes = [
        [low + PITCH / 2 + PITCH * k for k in range(int((high - low) / PITCH + 1e-9))]
        for low, high in workspace_of(robot).region
    ]
    return [(x, y) for x in axes[0] for y in axes[1]]


def capacity(robot: Robot) -> int:
    """Return how many bodies the workspace has room for."""
    return len(_grid(robot))


def spots(robot: Robot, generator: np.random.Generator, count: int) -> list[tuple[float, float]]:
    """Return places on the table in the workspace, at least `SEPARATION` apart, world frame [m]."""
    grid = _grid(robot)
    while True:
        chosen = [grid[k] for k in generator.permutation(len(grid))[:count]]
        places = np.array(chosen) + generator.uniform(-JITTER, JITTER, (count, 2))
        gaps = np.linalg.norm(places[:, None] - places[None], axis=2) + np.eye(count)
        if gaps.min() >= SEPARATION:
            return [(float(x), float(y)) for x, y in places]


def half_of(robot: Robot) -> float:
    """Return half the edge of the cubes for an arm [m]."""
    return min(HALF, gripper_of(robot).maximum_opening - CUBE_FINGER_ROOM)


def cube(name: str, place: tuple[float, float], yaw: float, number: int = 0, half: float = HALF) -> Body:
    """Return a cube on the table, turned about the vertical [rad]."""
    quaternion = (0.0, 0.0, math.sin(yaw / 2), math.cos(yaw / 2))
    return Body(name, Box((half,) * 3), (*place, half), quaternion, colour=COLOURS[number % len(COLOURS)])


def cubes(robot: Robot, generator: np.random.Generator, count: int) -> list[Body]:
    """Return cubes named cube0, cube1 …, at most as many as the workspace has room for."""
    count = min(count, capacity(robot))
    places = spots(robot, generator, count)
    yaws = generator.uniform(-math.pi, math.pi, count).tolist()
    half = half_of(robot)
    return [
        cube(f"cube{k}", place, yaw, k, half) for k, (place, yaw) in enumerate(zip(places, yaws, strict=True))
    ]


def crowded(robot: Robot, generator: np.random.Generator, count: int) -> list[Body]:
    """Return cubes, a pillar among them and a bin beside them, as far as the workspace has room."""
    count = min(count, capacity(robot) - 1)
    places = spots(robot, generator, count + 1)
    yaws = generator.uniform(-math.pi, math.pi, count).tolist()
    half = half_of(robot)
    bodies = [cube(f"cube{k}", places[k], yaws[k], k, half) for k in range(count)]
    (x0, x1), (_, y1) = workspace_of(robot).region
    pillar = Body("pillar", PILLAR, (*places[-1], PILLAR.half_extents[2]), mass=0.0)
    return [*bodies, pillar, Body("bin", tub(), ((x0 + x1) / 2, y1 + 0.13, 0.0425), mass=0.0)]
