"""Measures the one core: calibration of its grounding, rule against learnt dispatcher, and times.

python benchmarks/one_core.py calibration
python benchmarks/one_core.py dispatch --episodes 20
python benchmarks/one_core.py times
"""

from __future__ import annotations

import argparse
import json
from dataclasses import replace
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory
from time import perf_counter
from typing import Any

import numpy as np
import torch

from ntp_dsl.common.garbage import collect_seldom
from ntp_dsl.common.resources import examples_folder
from ntp_dsl.core.dispatch.dispatcher import Dispatcher, Situation
from ntp_dsl.core.dispatch.learned import LearnedDispatcher
from ntp_dsl.core.dispatch.rule import RuleDispatcher
from ntp_dsl.core.one_core import load_one_core, shipped_core
from ntp_dsl.core.perception.grounding import ground_all
from ntp_dsl.core.perception.perceived import Perceived
from ntp_dsl.core.perception.tracking import Tracker
from ntp_dsl.core.shown import Shown
from ntp_dsl.evaluation.episodes import Evaluator, Plan, run_all
from ntp_dsl.language.registry import Registry
from ntp_dsl.semantics.facts import Literal
from ntp_dsl.semantics.observation import Observation
from ntp_dsl.semantics.predicates import BUILT_IN
from ntp_dsl.semantics.state import State
from ntp_dsl.traces.decision import Dispatch
from ntp_dsl.traces.report.reliability import Reliability
from ntp_dsl.worlds.catalogue import equip
from ntp_dsl.worlds.kinematic import KinematicWorld
from ntp_dsl.worlds.protocol import UNDISTURBED, Disturbances, Scene, World

DOMAINS = Path(__file__).parents[1] / "tests" / "evaluation" / "domains"
TASKS = (
    (examples_folder() / "block_stacking", "block_stacking"),
    (examples_folder() / "seating", "seating"),
    (examples_folder() / "object_sorting", "object_sorting"),
    (examples_folder() / "table_cleanup", "table_cleanup"),
    (examples_folder() / "set_the_table", "set_the_table"),
    (DOMAINS / "hanoi", "any_arrangement"),
    (DOMAINS / "picnic", "picnic"),
    (DOMAINS / "vending", "vending"),
)
IN_PYTHON = (examples_folder() / "blueprint", "blueprint")  # as `set_the_table` is
SIXTY = """
task sixty:
    scene:   as object_sorting with
        toys:   15
        tools:  15
        fruits: 15
        cups:   15
    goal:    matchings(Category, bins, pairs=4) -> list[Mapping]
    run:     sort(goal)
    success: all in(o, m.bin) for m in goal for o in Item if category(o) == m.category
"""
NOISES = (0.0, 0.004, 0.008, 0.012, 0.016, 0.02)  # standard [m]
CONSTANT = 0.008  # error of each object's position, the same at each look [m]


# Calibration ------------------------------------------------------------------------------------


def calibration(arguments: argparse.Namespace) -> dict[str, Any]:
    """Return the expected calibration error (10 bins) of each predicate at each noise, over episodes."""
    core = load_one_core(arguments.model)
    found: dict[str, dict[str, float]] = {}
    for noise in NOISES:
        told: dict[str, list[tuple[float, bool]]] = {}
        for library, task in TASKS:
            for registry, seen, truth in _looks(library, task, arguments.episodes, noise):
                perceived = Perceived(registry, seen, core.grounding)
                true = State(registry, truth)
                for literal in _asked(registry, truth):
                    told.setdefault(literal.predicate, []).append(
                        (float(perceived.probability(literal)), true.holds(literal))
                    )
        found[f"{1000 * noise:g} mm"] = {
            name: round(Reliability.of(rows).error, 4) for name, rows in sorted(told.items())
        }
    return found


def _looks(library: Path, task: str, episodes: int, noise: float) -> Any:
    """Yield what a tracker makes of the looks in the expert's episodes, and the truth."""
    evaluator = Evaluator(Plan(library, task, None, disturbances=Disturbances(0.1, 0.1, noise)))
    for number in range(episodes):
        rows: list[tuple[Observation, Observation]] = []
        note = partial(_note, rows, Tracker(), evaluator.world)
        evaluator.episode(number, on_frame=note)
        for seen, truth in rows[::5]:
            yield evaluator.registry, seen, truth


def _note(rows: list[Any], tracker: Tracker, world: World, _: Observation) -> None:
    rows.append((tracker.update(world.observe()), world.truth()))


def _asked(registry: Registry, truth: Observation) -> list[Literal]:
    """Return the facts that may be asked: of all objects, and of pairs that are near."""
    names = [obj.name for obj in truth.objects]
    movable = [obj.name for obj in truth.objects if obj.movable]
    asked = [Literal(p, (n,)) for p in ("clear",) for n in names if p in registry.predicates]
    asked += [Literal("holding", (n,)) for n in movable]
    asked += [Literal("above", ("gripper", n)) for n in names]
    for name in ("on", "covers", "in"):
        if name in registry.predicates:
            asked += [
                Literal(name, (a, b)) for a in movable for b in names if a != b and _are_near(truth, a, b)
            ]
    return [each for each in asked if each.predicate in BUILT_IN]


def _are_near(truth: Observation, a: str, b: str) -> bool:
    way = np.abs(np.subtract(truth.positions[a], truth.positions[b]))[:2]
    reach = (np.array(truth.by_name[a].size[:2]) + truth.by_name[b].size[:2]) / 2
    return bool((way < reach + 0.04).all())


# Rule and learnt dispatcher ---------------------------------------------------------------------


class BiasedWorld(KinematicWorld):
    """A kinematic world in which each object is seen a little off, always in the same way."""

    def reset(self, scene: Scene, seed: int, disturbances: Disturbances = UNDISTURBED) -> None:
        super().reset(scene, seed, disturbances)
        rng = np.random.default_rng((seed, 2))
        self._bias = {obj.name: rng.normal(0, CONSTANT, 3) for obj in scene.objects if obj.movable}

    def observe(self) -> Observation:
        seen = super().observe()
        positions = {
            name: tuple((np.array(at) + self._bias.get(name, 0.0)).tolist())
            for name, at in seen.positions.items()
        }
        return replace(seen, positions=positions, deviations=dict.fromkeys(positions, CONSTANT))


def dispatch(arguments: argparse.Namespace) -> dict[str, Any]:
    """Return the success of rule and learnt dispatcher over the same facts, at each noise.

    Of programs whose bodies are declared, and of libraries in which a program leaves its body to Python.
    """
    found: dict[str, dict[str, dict[str, float]]] = {}
    for name in (*(f"{1000 * noise:g} mm" for noise in NOISES), "constant 8 mm"):
        found[name] = {}
        for way in Dispatch:
            shares: dict[str, list[float]] = {}
            for library, task in (*TASKS, IN_PYTHON):
                plan = Plan(library, task, arguments.model, seed=arguments.seed, dispatch=way)
                evaluator = Evaluator(plan)
                wins = _wins(plan, evaluator, name, arguments.episodes)
                in_python = any(row.in_python for row in evaluator.registry.programs.values())
                kind = "bodies in Python" if in_python else "declared bodies"
                shares.setdefault(kind, []).append(wins / arguments.episodes)
            found[name][str(way)] = {kind: round(sum(each) / len(each), 3) for kind, each in shares.items()}
        print(name, found[name], flush=True)
    return found


def _wins(plan: Plan, evaluator: Evaluator, noise: str, episodes: int) -> int:
    """Return how many episodes succeed."""
    if not noise.startswith("constant"):
        noisy = replace(plan, disturbances=Disturbances(noise=float(noise.split()[0]) / 1000))
        return sum(bool(each.success) for each in run_all(noisy, episodes, 1))
    wins, clean, world = 0, evaluator.world, BiasedWorld()
    equip(world, evaluator.registry)
    for number in range(episodes):
        evaluator.world = clean
        shown, _ = evaluator.demonstration(evaluator.instance(number), number)
        evaluator.world = world
        wins += bool(evaluator.episode(number, shown).success)
    return wins


# Times ------------------------------------------------------------------------------------------


def times(arguments: argparse.Namespace) -> dict[str, Any]:
    """Return the median times of a decision alone and in a batch of 50, and of reading demonstrations."""
    core = load_one_core(arguments.model)
    torch.set_num_threads(1)
    found: dict[str, Any] = {}
    evaluator = Evaluator(Plan(*TASKS[0], None))
    instance = evaluator.instance(0)
    shown = Shown(evaluator.registry, evaluator.demonstration(instance, 0)[0].demonstration, core.grounding)
    reading = shown.reading(instance.program, instance.arguments, (0, len(shown.demonstration)))
    calls = [call for call in reading.call.walk() if call.name in evaluator.registry.programs]
    seen = [shown.look(frame) for frame in range(len(shown.demonstration))]
    dispatchers: dict[str, Dispatcher] = {
        "rule": RuleDispatcher(shown.expert),
        "learned": LearnedDispatcher(shown.expert, core.dispatch),
    }
    for name, dispatcher in dispatchers.items():
        alone = []
        for number, look in enumerate(seen):
            call = calls[number % len(calls)]
            start = perf_counter()
            dispatcher.dispatch([Situation(call.name, call.arguments, shown.perceive(look))])
            alone.append(perf_counter() - start)
        batch = []
        for first in range(0, len(seen) - 50, 10):
            start = perf_counter()
            situations = []
            for number, graded in enumerate(ground_all(core.grounding, seen[first : first + 50])):
                state = shown.perceive(seen[first + number])
                state.graded = graded
                call = calls[number % len(calls)]
                situations.append(Situation(call.name, call.arguments, state))
            dispatcher.dispatch(situations)
            batch.append((perf_counter() - start) / 50)
        found[f"decision by {name}, 8 objects [us]"] = round(1e6 * float(np.median(alone)))
        found[f"the same, in a batch of 50 [us], by {name}"] = round(1e6 * float(np.median(batch)))
    sorting = examples_folder() / "object_sorting"
    for task, label in (
        ("object_sorting", "15 objects"),
        ("many_objects", "45 objects"),
        ("sixty", "65 objects"),
        ("crowded", "105 objects"),
    ):
        with TemporaryDirectory() as folder:
            text = (sorting / "object_sorting.ntp").read_text() + SIXTY
            Path(folder, "object_sorting.ntp").write_text(text)
            evaluator = Evaluator(Plan(Path(folder), task, None))
        spent = []
        for number in range(3):
            instance = evaluator.instance(number)
            demonstration = evaluator.demonstration(instance, number)[0].demonstration
            start = perf_counter()
            shown = Shown(evaluator.registry, demonstration, core.grounding)
            shown.reading(instance.program, instance.arguments, (0, len(demonstration)))
            spent.append(perf_counter() - start)
        found[f"reading, {label} [s]"] = round(float(np.median(spent)), 3)
    return found


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("what", choices=["calibration", "dispatch", "times"])
    parser.add_argument("--episodes", type=int, default=10)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--model", type=Path, default=shipped_core())
    arguments = parser.parse_args()
    collect_seldom()  # as the command line does
    measure = {"calibration": calibration, "dispatch": dispatch, "times": times}[arguments.what]
    print(json.dumps(measure(arguments), indent=1))


if __name__ == "__main__":
    main()
