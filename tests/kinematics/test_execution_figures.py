"""The figures of execution: from a few runs here, with `--soak` from as many as are claimed."""

import math
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest

from kinematics.bench import sim
from kinematics.bench.cells import HALF, cube, cubes
from kinematics.robot.robot import Robot
from kinematics.shapes.bodies import Body
from kinematics.shapes.pose_noise import NO_NOISE, Noise
from kinematics.simulation.bullet_cell import BulletCell
from kinematics.simulation.simulated_cell import SimulatedCell
from kinematics.skills.routines import pick, place

SURE, UNSURE = Noise(0.002, math.radians(2)), Noise(0.005, math.radians(2))


@pytest.fixture(params=sim.CELLS)
def engine(request: pytest.FixtureRequest) -> str:
    return str(request.param)


@pytest.fixture
def arm_cell(robot: Robot, engine: str) -> Iterator[SimulatedCell]:
    """Every arm's, in every engine."""
    with sim.CELLS[engine][1](robot) as made:
        yield made


def stacked(cell: SimulatedCell, seed: int, noise: Noise = NO_NOISE) -> float | None:
    """Run one cycle; return how far off centre the cube is on the other [m], or None if it is not."""
    cell.reset(cubes(cell.robot, np.random.default_rng((7, seed)), 8), seed, noise)
    if not (pick(cell, "cube0", seed).achieved and place(cell, "cube1", seed).achieved):
        return None
    cell.settle(0.5)
    item, support = cell.pose("cube0").position, cell.pose("cube1").position
    off = math.dist(item[:2], support[:2])
    stands = abs(item[2] - support[2] - 2 * HALF) < 0.005 and off < HALF
    return off if stands else None


def test_cycles_of_pick_and_place_never_fail(arm_cell: SimulatedCell, soak: bool) -> None:
    offs = [stacked(arm_cell, seed) for seed in range(500 if soak else 3)]
    assert [seed for seed, off in enumerate(offs) if off is None] == []
    assert float(np.quantile([off for off in offs if off is not None], 0.95)) <= 1e-3


@pytest.mark.parametrize(("noise", "least"), [(SURE, 0.99), (UNSURE, 0.95)], ids=["2 mm", "5 mm"])
def test_cycles_tolerate_noise_on_observed_poses(
    cell: SimulatedCell, noise: Noise, least: float, soak: bool
) -> None:
    seeds = range(500 if soak else 3)
    assert np.mean([stacked(cell, seed, noise) is not None for seed in seeds]) >= least


def test_towers_of_eight_stand(cell: SimulatedCell, soak: bool) -> None:
    for seed in range(50 if soak else 1):
        cell.reset(cubes(cell.robot, np.random.default_rng((8, seed)), 8), seed)
        for level in range(7):
            for motion in (pick(cell, f"cube{level + 1}", seed), place(cell, f"cube{level}", seed)):
                assert motion.achieved, (seed, level, motion)
        cell.settle(2.0)
        assert cell.pose("cube7").position[2] == pytest.approx(15 * HALF, abs=5e-3), seed


class WatchedCell(BulletCell):
    """A cell that notes at every step which bodies the robot or the held body touches."""

    def reset(self, *arguments: Any, **options: Any) -> None:
        self.touching: set[str] = set()
        super().reset(*arguments, **options)

    def step(self) -> None:
        super().step()
        self.touching |= self.pressed()
        held = self.held()
        if held is not None:
            self.touching |= {name for name in self.bodies if name != held and self.contacts(held, name)}


def test_carried_cubes_pass_between_towers_without_touching_them(soak: bool) -> None:
    with WatchedCell() as cell:
        for seed in range(50 if soak else 2):
            cell.reset(_gate(np.random.default_rng((9, seed))), seed)
            for motion in (pick(cell, "item", seed), place(cell, "goal", seed)):
                assert motion.achieved, (seed, motion)
            assert {"item"} <= cell.touching <= {"item", "goal"}, seed


def _gate(generator: np.random.Generator) -> list[Body]:
    """Return two towers of four, a cube in front of them, and one behind."""
    gap = generator.uniform(0.12, 0.16)
    bodies = []
    for side, y in (("left", gap), ("right", -gap)):
        x = generator.uniform(0.47, 0.53)
        for level in range(4):
            low = cube(f"{side}{level}", (x, y), 0.0, level)
            bodies.append(Body(low.name, low.shape, (x, y, HALF + 2 * HALF * level), colour=low.colour))
    yaws = generator.uniform(-math.pi, math.pi, 2).tolist()
    return [*bodies, cube("item", (0.37, 0.15), yaws[0], 1), cube("goal", (0.62, -0.12), yaws[1], 2)]


def test_a_replay_of_motor_commands_ends_bit_for_bit_in_the_same_state(
    arm_cell: SimulatedCell, engine: str
) -> None:
    bodies = cubes(arm_cell.robot, np.random.default_rng(3), 4)
    with sim.CELLS[engine][0](arm_cell.robot) as cell:
        for each in (cell, arm_cell):
            each.reset(bodies, 3)
        cell.commands.clear()
        assert sim.cycle(cell, 3)
        sim.replay(cell.commands, arm_cell)
        assert arm_cell.poses() == cell.poses() and arm_cell.time == cell.time > 1.0
        assert np.array_equal(arm_cell.joint_positions(), cell.joint_positions())


def test_the_benchmark_of_execution_reports_success_and_overhead() -> None:
    for ours in sim.bench(1, 0)["ours"].values():
        assert (ours["cycles"], ours["achieved"]) == (1, 1.0)
        assert ours["real_time_factor"] > 0 and ours["overhead"] > -1
