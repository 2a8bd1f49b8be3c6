"""Repeated pick and place in the simulated cell: failures, their reasons, and times.

python benchmarks/pick_and_place.py single --runs 200
python benchmarks/pick_and_place.py episode --runs 20
python benchmarks/pick_and_place.py tower --runs 20
python benchmarks/pick_and_place.py slips --runs 40
python benchmarks/pick_and_place.py pushes --runs 40
python benchmarks/pick_and_place.py clutter --runs 40
"""

import argparse
import collections
import json
import math
import sys
import time
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from kinematics.bench.cells import HALF, cube
from kinematics.geometry.transforms import rotation_from_quaternion
from kinematics.robot import robot
from kinematics.shapes.bodies import Body
from kinematics.simulation.bullet_cell import BulletCell
from kinematics.skills.approach import TILTED
from kinematics.skills.skills import Motion, grasp, move_above, move_above_free_place, release


@dataclass
class Tally:
    """Measurements over all runs."""

    outcomes: collections.Counter[str] = field(default_factory=collections.Counter)
    failures: list[str] = field(default_factory=list)
    errors_mm: list[float] = field(default_factory=list)
    planning: dict[str, list[float]] = field(default_factory=lambda: collections.defaultdict(list))
    simulated: dict[str, list[float]] = field(default_factory=lambda: collections.defaultdict(list))
    cpu: list[float] = field(default_factory=list)
    wall: list[float] = field(default_factory=list)
    episode_simulated: list[float] = field(default_factory=list)

    def add(self, skill: str, motion: Motion, where: str) -> None:
        """Count the outcome of a skill, and keep its times."""
        outcome = "achieved" if motion.achieved else str(motion.reason)
        self.outcomes[f"{skill}: {outcome}"] += 1
        self.planning[skill].append(motion.planning_seconds)
        self.simulated[skill].append(motion.simulated_seconds)
        if not motion.achieved:
            self.failures.append(f"{where} {skill} {motion.reason} {motion.evidence}")

    def report(self) -> dict[str, Any]:
        """Return all figures."""
        return {
            "outcomes": dict(sorted(self.outcomes.items())),
            "placement_error_mm": _spread(self.errors_mm),
            "planning_ms": {k: _spread([1000 * s for s in v]) for k, v in self.planning.items()},
            "simulated_s": {k: _spread(v) for k, v in self.simulated.items()},
            "cpu_s_per_run": _spread(self.cpu),
            "wall_s_per_run": _spread(self.wall),
            "simulated_s_per_run": _spread(self.episode_simulated),
        }


def _spread(values: list[float]) -> dict[str, float]:
    if not values:
        return {}
    return {
        "mean": round(float(np.mean(values)), 3),
        "median": round(float(np.median(values)), 3),
        "p95": round(float(np.quantile(values, 0.95)), 3),
        "max": round(max(values), 3),
    }


def scattered(generator: np.random.Generator, count: int) -> list[Body]:
    """Return cubes on a jittered 0.1 m grid, centres at least 8 cm apart, at random yaws."""
    cells = [(x, y) for x in (0.35, 0.45, 0.55, 0.65) for y in (-0.15, -0.05, 0.05, 0.15)]
    while True:
        chosen = generator.permutation(len(cells))[:count]
        centres = np.array([cells[i] for i in chosen]) + generator.uniform(-0.03, 0.03, (count, 2))
        gaps = np.linalg.norm(centres[:, None] - centres[None], axis=2) + np.eye(count)
        if gaps.min() >= 0.08:
            break
    yaws = generator.uniform(-math.pi, math.pi, count).tolist()
    placed = enumerate(zip(centres.tolist(), yaws, strict=True))
    return [cube(f"b{i}", (x, y), yaw, i) for i, ((x, y), yaw) in placed]


def is_on(cell: BulletCell, item: str, support: str) -> bool:
    """Return whether a cube is on another: centred within half a cube, one cube higher, in contact."""
    a, b = cell.pose(item).position, cell.pose(support).position
    near = math.hypot(a[0] - b[0], a[1] - b[1]) < HALF
    return near and abs(a[2] - b[2] - 2 * HALF) < 0.01 and cell.contacts(item, support)


class Runner:
    """A cell, and the building blocks of scripts."""

    def __init__(self, cell: BulletCell, tally: Tally, pictures: str | None) -> None:
        self.cell, self.tally, self.pictures = cell, tally, pictures
        self.where = ""
        self.calls = 0

    def call(self, skill: Any, *arguments: Any, **options: Any) -> bool:
        """Call a skill, add it to the tally, and return whether it succeeded."""
        self.calls += 1
        motion = skill(self.cell, *arguments, seed=self.calls, **options)
        self.tally.add(skill.__name__, motion, f"{self.where} {arguments}")
        if not motion.achieved and self.pictures and not options.get("slip_at"):
            self.picture(f"{self.where}-{self.calls}-{skill.__name__}-{motion.reason}")
        return bool(motion.achieved)

    def picture(self, name: str) -> None:
        """Save a picture of the cell."""
        from PIL import Image

        pixels = self.cell.render(640, 480)
        Image.fromarray(pixels).save(f"{self.pictures}/{name.replace(' ', '_')}.png")

    def place(self, item: str, support: str, **options: Any) -> bool:
        """Pick up a cube and place it on another, without a second attempt."""
        done = self.call(move_above, item) and self.call(grasp, item)
        done = done and self.call(move_above, support, **options) and self.call(release)
        if done:
            a, b = self.cell.pose(item).position, self.cell.pose(support).position
            self.tally.errors_mm.append(1000 * math.hypot(a[0] - b[0], a[1] - b[1]))
        return done

    def covering(self, name: str) -> list[str]:
        """Return the bodies on another: higher, and in contact with it."""
        cell = self.cell
        height = cell.pose(name).position[2]
        return [
            other
            for other in cell.bodies
            if other != name and cell.pose(other).position[2] > height + 0.015 and cell.contacts(other, name)
        ]

    def build(self, placements: list[tuple[str, str]], calls: int, **slips: Any) -> bool:
        """Repeat, as a scripted expert with recovery, until every placement holds or the calls run out."""
        limit = self.calls + calls
        while self.calls < limit:
            due = next((p for p in placements if not is_on(self.cell, *p)), None)
            held = self.cell.held()
            if due is None:
                return held is None
            item, support = due
            tilted = self.tilted(support)
            if tilted and held is None:
                self.take(self.obstacle(support, support))
            elif held == item and not self.covering(support) and not tilted:
                if self.call(move_above, support, **self.slip(slips)):
                    self.call(release)
            elif held is not None:  # a tilted support is put down flat, as is a body that is not needed now
                if self.call(move_above_free_place):
                    self.call(release)
            else:
                self.take(self.obstacle(item, support))
        return False

    def tilted(self, name: str) -> bool:
        """Return whether a cube is too tilted to support another."""
        rotation = rotation_from_quaternion(self.cell.pose(name).quaternion_xyzw)
        return bool(np.abs(rotation[2]).max() < math.cos(TILTED))

    def obstacle(self, item: str, support: str) -> str:
        """Return the cube that must be moved first to place an item on a support: itself, or one on top."""
        for name in (support, item):
            on_top = self.covering(name)
            if on_top and on_top != [item]:
                first = next(other for other in on_top if other != item)
                return self.obstacle(first, first)
        return item

    def take(self, name: str) -> None:
        """Grasp a cube."""
        if self.call(move_above, name):
            self.call(grasp, name)

    def slip(self, slips: dict[str, Any]) -> dict[str, Any]:
        """Return the options of a motion, with a slip in a share of the calls."""
        generator, share = slips.get("generator"), slips.get("share", 0.0)
        if generator is None or generator.uniform() >= share:
            return {}
        return {"slip_at": float(generator.uniform(0.2, 0.9))}


def single(runner: Runner, generator: np.random.Generator) -> bool:
    """Place one cube on another."""
    return runner.place("b0", "b1")


def episode(runner: Runner, generator: np.random.Generator) -> bool:
    """Build a tower of 3 and one of 2 or 3, with 4 or 5 placements as in an average task."""
    pairs = [("b1", "b0"), ("b2", "b1"), ("b4", "b3"), ("b5", "b4")]
    if generator.uniform() < 0.4:
        pairs.append(("b7", "b6"))
    return all([runner.place(*pair) for pair in pairs])


def tower(runner: Runner, generator: np.random.Generator) -> bool:
    """Build a tower of 5."""
    return all([runner.place(f"b{i + 1}", f"b{i}") for i in range(4)])


def slips(runner: Runner, generator: np.random.Generator) -> bool:
    """Build two towers while a quarter of the carried cubes slip."""
    pairs = [(f"b{i + 1}", f"b{i}") for i in range(3)] + [("b5", "b4"), ("b6", "b5")]
    return runner.build(pairs, 80, generator=generator, share=0.25)


def pushes(runner: Runner, generator: np.random.Generator) -> bool:
    """Build a tower that is pushed over twice."""
    pairs = [(f"b{i + 1}", f"b{i}") for i in range(3)]
    for top in ("b2", "b3"):
        if not runner.build(pairs[: int(top[1])], 60):
            return False
        x, y, _ = runner.cell.pose(top).position  # push inwards, so that the cube stays on the table
        angle = math.atan2(-y, 0.45 - x) + generator.uniform(-1.0, 1.0)
        runner.cell.push(top, 0.12, (math.cos(angle), math.sin(angle)))
    return runner.build(pairs, 60)


def clutter(runner: Runner, generator: np.random.Generator) -> bool:
    """Drop three cubes from a height onto the others, then build a tower of these."""
    for name in ("b0", "b1", "b2"):
        if not (runner.call(move_above, name) and runner.call(grasp, name)):
            return False
        runner.call(move_above, "b3", slip_at=float(generator.uniform(0.5, 0.98)))
        if runner.cell.held() and not (runner.call(move_above_free_place) and runner.call(release)):
            return False
    return runner.build([("b1", "b0"), ("b2", "b1")], 60)


SCRIPTS = {
    "single": (single, 8),
    "episode": (episode, 8),
    "tower": (tower, 8),
    "slips": (slips, 8),
    "pushes": (pushes, 8),
    "clutter": (clutter, 10),
}


def main() -> int:
    """Run a script many times, and print the figures as JSON."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("script", choices=SCRIPTS)
    parser.add_argument("--runs", type=int, default=20)
    parser.add_argument("--seed", type=int, default=0, help="of the first run")
    parser.add_argument("--arm", default="panda", help="an included arm, or the path of a TOML")
    parser.add_argument("--pictures", help="folder for a picture of every failure")
    options = parser.parse_args()
    script, count = SCRIPTS[options.script]
    tally, succeeded = Tally(), 0
    with BulletCell(robot.load(options.arm)) as cell:
        runner = Runner(cell, tally, options.pictures)
        for run in range(options.seed, options.seed + options.runs):
            generator = np.random.default_rng(run)
            runner.where, runner.calls = f"run {run}", 1000 * run
            started, busy = time.perf_counter(), time.process_time()
            cell.reset(scattered(generator, count), seed=run)
            done = script(runner, generator)
            succeeded += done
            if not done:
                tally.failures.append(f"run {run} FAILED")
                if options.pictures:
                    runner.picture(f"{run}-failed")
            tally.wall.append(time.perf_counter() - started)
            tally.cpu.append(time.process_time() - busy)
            tally.episode_simulated.append(cell.time)
    print("\n".join(tally.failures), file=sys.stderr)
    print(json.dumps({"succeeded": f"{succeeded}/{options.runs}", **tally.report()}, indent=1))
    return 0


if __name__ == "__main__":
    sys.exit(main())
