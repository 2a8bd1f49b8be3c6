"""What a driver of a real arm has to answer: a skill asks a cell for nothing else, and needs no simulator."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from kinematics.bench.cells import cubes
from kinematics.shapes.pose_noise import Noise
from kinematics.simulation.cell import Cell
from kinematics.simulation.simulated_cell import SimulatedCell
from kinematics.skills import skills
from kinematics.skills.skills import Motion

MEMBERS = frozenset(name for name in dir(Cell) if not name.startswith("_")) | {"stop_requested"}
Note = tuple[str, tuple[Any, ...], Any]  # what was asked or commanded, with what, and the answer


class Recorded:
    """A cell of which no more can be had than a driver brings; all of it is noted."""

    def __init__(self, cell: SimulatedCell) -> None:
        self.__dict__.update(cell=cell, notes=[])

    def __getattr__(self, name: str) -> Any:
        assert name in MEMBERS, f"skills may not use {name}: it is no part of `Cell`"
        value = getattr(self.cell, name)
        if not callable(value):
            self.notes.append((name, (), value))
            return value

        def asked(*arguments: Any) -> Any:
            answer = value(*arguments)
            self.notes.append((name, _plain(arguments), answer))
            return answer

        return asked

    def __setattr__(self, name: str, value: Any) -> None:
        assert name == "stop_requested"
        setattr(self.cell, name, value)


class Replayed:
    """A driver without an arm: it answers as was recorded, and takes the same commands in the same order."""

    def __init__(self, notes: list[Note]) -> None:
        self.__dict__.update(notes=iter(notes))

    def __getattr__(self, name: str) -> Any:
        def asked(*given: Any) -> Any:
            noted, arguments, answer = next(self.notes)
            assert (name, _plain(given)) == (noted, arguments)
            return answer

        return asked if callable(getattr(SimulatedCell, name, None)) else asked()

    def __setattr__(self, name: str, value: Any) -> None:
        assert name == "stop_requested"


def _plain(arguments: tuple[Any, ...]) -> tuple[Any, ...]:
    return tuple(each.tolist() if isinstance(each, np.ndarray) else each for each in arguments)


def pick_and_place(cell: Cell) -> Iterator[Motion]:
    yield skills.move_above(cell, "cube0", 1)
    yield skills.grasp(cell, "cube0", 2)
    yield skills.move_above(cell, "cube1", 3, 0.5)
    yield skills.move_above(cell, "cube0", 4)
    yield skills.grasp(cell, "cube0", 5)
    yield skills.move_above(cell, "cube1", 6)
    yield skills.release(cell, 7)
    yield skills.push(cell, "cube2", (1.0, 0.0), 0.03, 8)
    yield skills.move_above(cell, "cube2", 9)
    yield skills.grasp(cell, "cube2", 10)
    yield skills.turn_held(cell, 0.5, 11)
    yield skills.move_above_free_place(cell, 12)
    yield skills.release(cell, 13)


def without_wall_times(motions: Iterator[Motion]) -> list[Motion]:
    return [replace(motion, planning_seconds=0.0, moving_seconds=0.0) for motion in motions]


@pytest.mark.parametrize("noise", [0.0, 0.002])  # with noise they feel their way
def test_skills_run_on_a_replayed_recording_as_on_the_cell_that_it_is_of(
    cell: SimulatedCell, noise: float
) -> None:
    cell.reset(cubes(cell.robot, np.random.default_rng(2), 4), 2, Noise(noise))
    recorded: Any = Recorded(cell)
    motions = without_wall_times(pick_and_place(recorded))
    assert [motion.achieved for motion in motions] == [True, True, False, *[True] * 10]
    assert ("joint_torques" in {name for name, _, _ in recorded.notes}) == bool(noise)
    replayed: Any = Replayed(recorded.notes)
    assert without_wall_times(pick_and_place(replayed)) == motions
    with pytest.raises(StopIteration):
        next(replayed.notes)
