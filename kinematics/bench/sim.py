"""Execution: what the skills cost over replaying their own motor commands with the same settings."""

import math
import time
from collections.abc import Callable
from typing import Any

import numpy as np

from kinematics import skills
from kinematics.bench.cells import cubes
from kinematics.bench.measuring import machine, quantile_ms, share
from kinematics.bodies import Body
from kinematics.robot import Robot, panda
from kinematics.simulation import Workcell

CUBES = 8


class RecordingCell(Workcell):
    """A cell that keeps every command it is given."""

    def __init__(self, robot: Robot) -> None:
        self.commands: list[tuple[Callable[..., None], tuple[Any, ...]]] = []
        super().__init__(robot)

    def drive_arm(self, position: Any, velocity: Any) -> None:
        self.commands.append((Workcell.drive_arm, (position, velocity)))
        super().drive_arm(position, velocity)

    def open_fingers(self, opening: float) -> None:
        self.commands.append((Workcell.open_fingers, (opening,)))
        super().open_fingers(opening)

    def close_fingers(self) -> None:
        self.commands.append((Workcell.close_fingers, ()))
        super().close_fingers()

    def step(self) -> None:
        self.commands.append((Workcell.step, ()))
        super().step()


def bench(cycles: int, seed: int, robot: Robot | None = None) -> dict[str, Any]:
    """`ours`: pick-and-place cycles by the skills alone; no peer does the same work."""
    robot = robot or panda()
    wall: list[float] = []
    busy: list[float] = []
    overheads, achieved, factors = [], [], []
    cell = RecordingCell(robot)
    with cell, Workcell(robot) as other:
        for number in range(-1, cycles):  # the first warms the solvers up
            bodies = cubes(robot, np.random.default_rng((seed, number + 1)), CUBES)
            took, done = _cycle(cell, bodies, seed + number + 1)
            again = _replayed(cell, other, bodies, seed + number + 1)
            if number < 0:
                continue
            achieved.append(done)
            wall.append(took[0])
            busy.append(took[1])
            overheads.append(took[1] / again - 1.0)
            factors.append(cell.time / took[0])
    return {
        "ours": {
            "cycles": cycles,
            "achieved": share(achieved),
            "overhead": _median(overheads),
            "overhead_p95": round(float(np.quantile(overheads, 0.95)), 3),
            "real_time_factor": _median(factors),
            "median_ms": quantile_ms(wall, 0.5),
            "p95_ms": quantile_ms(wall, 0.95),
            "cpu_median_ms": quantile_ms(busy, 0.5),
        },
        "peers": {},
        "machine": machine(),
    }


def _cycle(cell: RecordingCell, bodies: list[Body], seed: int) -> tuple[tuple[float, float], bool]:
    """Wall and CPU seconds of one cycle, without the reset."""
    cell.reset(bodies, seed)
    cell.commands.clear()
    started = time.perf_counter(), time.process_time()
    done = all(
        motion.achieved
        for motion in (
            skills.move_above(cell, "cube0", seed),
            skills.grasp(cell, "cube0", seed),
            skills.move_above(cell, "cube1", seed),
            skills.release(cell, seed),
        )
    )
    return (time.perf_counter() - started[0], time.process_time() - started[1]), done


def _replayed(cell: RecordingCell, other: Workcell, bodies: list[Body], seed: int) -> float:
    """CPU seconds of the same commands without a thought; the world ends up the same."""
    other.reset(bodies, seed)
    started = time.process_time()
    for command, arguments in cell.commands:
        command(other, *arguments)
    took = time.process_time() - started
    assert other.poses() == cell.poses(), "a replay is bit for bit the same"
    return took


def _median(values: list[float]) -> float:
    return round(float(np.median(values)), 3) if values else math.nan
