"""Benchmark of inverse kinematics: top-down and general poses, evaluated by one forward kinematics."""

import math
from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np

from kinematics.bench import ik_peers
from kinematics.bench.measuring import Tally, machine
from kinematics.geometry.transforms import Z_AXIS, Array, angle_between, rotation_about
from kinematics.ik.global_ik import InverseKinematics
from kinematics.robot.robot import Robot, panda
from kinematics.skills.workspace import FLOOR, workspace_of

POSITION = 1e-3  # [m]
ANGLE = 0.01  # [rad]
OUR_RESTARTS = 60  # of our solver, whose restarts are cheap

Solve = Callable[[Array, int], Array | None]  # tool transform and seed to joint positions


def bench(queries: int, seed: int, robot: Robot | None = None) -> dict[str, Any]:
    """Return the figures `ours`, `peers` and `machine`; those of a solver are `topdown` and `general`."""
    robot = robot or panda()
    sets = {"topdown": top_down(robot, queries, seed), "general": general(robot, queries, seed)}
    peers = {name: make(robot) for name, make in ik_peers.INSTALLED.items()}
    return {
        "ours": evaluated(robot, ours(robot), sets),
        "peers": {name: evaluated(robot, solve, sets) for name, solve in peers.items()},
        "machine": machine(),
    }


def ours(robot: Robot) -> Solve:
    """Return our solver, which takes its first solution."""
    solver = InverseKinematics(robot)

    def solve(target: Array, seed: int) -> Array | None:
        starts = solver.starts(target, robot.home, seed, OUR_RESTARTS)
        return next(solver.solutions(target, starts), None)

    return solve


def top_down(robot: Robot, count: int, seed: int) -> list[Array]:
    """Return tool transforms within reach that point straight down over the workspace, at any yaw."""
    generator = np.random.default_rng((seed, 1))
    workspace = workspace_of(robot)
    (x0, x1), (y0, y1) = workspace.region
    poses = []
    for _ in range(count):
        turn = rotation_about(Z_AXIS, generator.uniform(-math.pi, math.pi))
        pose = np.eye(4)
        pose[:3, :3] = turn @ np.diag([1.0, -1.0, -1.0])
        pose[:3, 3] = generator.uniform((x0, y0, FLOOR), (x1, y1, workspace.ceiling))
        poses.append(pose)
    return poses


def general(robot: Robot, count: int, seed: int) -> list[Array]:
    """Return the tool transforms of random joint positions."""
    generator, solver = np.random.default_rng((seed, 2)), InverseKinematics(robot)
    limits = robot.limits
    return [solver.forward(q) for q in generator.uniform(limits.lower, limits.upper, (count, robot.dof))]


def evaluated(robot: Robot, solve: Solve, sets: dict[str, list[Array]]) -> dict[str, Any]:
    """Return the figures of a solver for each set of tool transforms."""
    return _Evaluator(robot).figures(solve, sets)


class _Evaluator:
    def __init__(self, robot: Robot) -> None:
        self._limits = robot.limits
        self._model = InverseKinematics(robot)

    def figures(self, solve: Solve, sets: dict[str, list[Array]]) -> dict[str, Any]:
        return {name: self._tally(solve, targets).figures() for name, targets in sets.items()}

    def _tally(self, solve: Solve, targets: list[Array]) -> Tally:
        tally = Tally()
        solve(targets[0], 0)  # the first call of a library pays for its imports
        for number, target in enumerate(targets):
            q = tally.timed(partial(solve, target, number))
            tally.solved.append(q is not None and self._is_correct(q, target))
        return tally

    def _is_correct(self, q: Array, target: Array) -> bool:
        reached = self._model.forward(q)
        near = float(np.linalg.norm(reached[:3, 3] - target[:3, 3])) <= POSITION
        turned = angle_between(reached[:3, :3], target[:3, :3]) <= ANGLE
        return near and turned and self._limits.contains(q, 1e-6)
