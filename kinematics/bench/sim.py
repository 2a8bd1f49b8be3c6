"""Benchmark of execution: the time of skills relative to replaying their motor commands."""

from collections.abc import Callable
from functools import partial
from typing import Any, TypeAlias

import numpy as np

from kinematics.bench.cells import CUBES, cubes
from kinematics.bench.measuring import Tally, machine
from kinematics.robot.robot import Robot, panda
from kinematics.simulation.bullet_cell import BulletCell
from kinematics.skills import skills

Command: TypeAlias = tuple[Callable[..., None], tuple[Any, ...]]


class RecordingCell(BulletCell):
    """A cell that records its commands."""

    def __init__(self, robot: Robot) -> None:
        self.commands: list[Command] = []
        super().__init__(robot)

    def drive_arm(self, position: Any, velocity: Any) -> None:
        self.commands.append((BulletCell.drive_arm, (position, velocity)))
        super().drive_arm(position, velocity)

    def open_fingers(self, *how: float) -> None:
        self.commands.append((BulletCell.open_fingers, how))
        super().open_fingers(*how)

    def close_fingers(self) -> None:
        self.commands.append((BulletCell.close_fingers, ()))
        super().close_fingers()

    def step(self) -> None:
        self.commands.append((BulletCell.step, ()))
        super().step()


def bench(cycles: int, seed: int, robot: Robot | None = None) -> dict[str, Any]:
    """Return the figures `ours` of pick-and-place cycles by skills; no peer does the same work."""
    robot = robot or panda()
    skilled, replayed = Tally(), Tally()
    simulated: list[float] = []
    with RecordingCell(robot) as cell, BulletCell(robot) as other:
        for number in range(cycles + 1):
            bodies = cubes(robot, np.random.default_rng((seed, number)), CUBES)
            for each in (cell, other):
                each.reset(bodies, seed + number)
            cell.commands.clear()
            skilled.solved.append(skilled.timed(partial(cycle, cell, seed + number)))
            replayed.timed(partial(replay, cell.commands, other))
            assert other.poses() == cell.poses(), "a replay ends bit for bit in the same state"
            simulated.append(cell.time)
            if number == 0:  # the first cycle warms the solvers up
                skilled, replayed, simulated = Tally(), Tally(), []
    overheads = np.divide(skilled.busy, replayed.busy) - 1.0
    figures = skilled.figures()
    return {
        "ours": {
            "cycles": figures.pop("queries"),
            "achieved": figures.pop("solved"),
            "overhead": round(float(np.median(overheads)), 3),
            "overhead_p95": round(float(np.quantile(overheads, 0.95)), 3),
            "real_time_factor": round(float(np.median(np.divide(simulated, skilled.wall))), 3),
            **figures,
        },
        "peers": {},
        "machine": machine(),
    }


def cycle(cell: BulletCell, seed: int) -> bool:
    """Pick up a cube and place it on another; return whether all skills succeeded."""
    return all(
        motion.achieved
        for motion in (
            skills.move_above(cell, "cube0", seed),
            skills.grasp(cell, "cube0", seed),
            skills.move_above(cell, "cube1", seed),
            skills.release(cell, seed),
        )
    )


def replay(commands: list[Command], other: BulletCell) -> None:
    """Send the same motor commands to another cell."""
    for command, arguments in commands:
        command(other, *arguments)
