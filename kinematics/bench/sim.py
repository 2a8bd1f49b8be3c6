"""Benchmark of execution in each engine: the time of skills relative to replaying their motor commands."""

from functools import partial
from typing import Any, TypeAlias

import numpy as np

from kinematics.bench.cells import CUBES, cubes
from kinematics.bench.measuring import Tally, machine
from kinematics.robot.robot import Robot, panda
from kinematics.simulation import pybullet_loading
from kinematics.simulation.bullet_cell import BulletCell
from kinematics.simulation.mujoco_cell import MujocoCell
from kinematics.simulation.simulated_cell import SimulatedCell
from kinematics.skills import skills

Command: TypeAlias = tuple[str, tuple[Any, ...]]


class RecordingCell(SimulatedCell):
    """A cell that records its commands."""

    def __init__(self, robot: Robot) -> None:
        self.commands: list[Command] = []
        super().__init__(robot)

    def drive_arm(self, position: Any, velocity: Any) -> None:
        self.commands.append(("drive_arm", (position, velocity)))
        super().drive_arm(position, velocity)

    def open_fingers(self, *how: float) -> None:
        self.commands.append(("open_fingers", how))
        super().open_fingers(*how)

    def close_fingers(self) -> None:
        self.commands.append(("close_fingers", ()))
        super().close_fingers()

    def step(self) -> None:
        self.commands.append(("step", ()))
        super().step()


class RecordingBulletCell(RecordingCell, BulletCell): ...


class RecordingMujocoCell(RecordingCell, MujocoCell): ...


CELLS: dict[str, tuple[type[RecordingCell], type[SimulatedCell]]] = {
    "bullet": (RecordingBulletCell, BulletCell),
    "mujoco": (RecordingMujocoCell, MujocoCell),
}


def bench(cycles: int, seed: int, robot: Robot | None = None) -> dict[str, Any]:
    """Return the figures `ours` of pick-and-place cycles by skills; no peer does the same work."""
    robot = robot or panda()
    figures = {
        name: _figures(cycles, seed, robot, *cells)
        for name, cells in CELLS.items()
        if name != "bullet" or pybullet_loading.is_installed()
    }
    return {"ours": figures, "peers": {}, "machine": machine()}


def _figures(
    cycles: int, seed: int, robot: Robot, recording: type[RecordingCell], plain: type[SimulatedCell]
) -> dict[str, Any]:
    skilled, replayed = Tally(), Tally()
    simulated: list[float] = []
    with recording(robot) as cell, plain(robot) as other:
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
        "cycles": figures.pop("queries"),
        "achieved": figures.pop("solved"),
        "overhead": round(float(np.median(overheads)), 3),
        "overhead_p95": round(float(np.quantile(overheads, 0.95)), 3),
        "real_time_factor": round(float(np.median(np.divide(simulated, skilled.wall))), 3),
        **figures,
    }


def cycle(cell: SimulatedCell, seed: int) -> bool:
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


def replay(commands: list[Command], other: SimulatedCell) -> None:
    """Send the same motor commands to another cell."""
    for command, arguments in commands:
        getattr(other, command)(*arguments)
