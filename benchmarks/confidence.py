"""Measures whether the one core knows what it has understood, where noise and slips make it fail.

python benchmarks/confidence.py --episodes 10 --noise 0.01 --slips 0.6
"""

from __future__ import annotations

import argparse
import json
from collections import defaultdict
from pathlib import Path
from typing import Any

import numpy as np
import torch

from ntp_dsl.common.resources import examples_folder
from ntp_dsl.core.one_core import shipped_core
from ntp_dsl.core.policy import OneShotPolicy
from ntp_dsl.core.reading.reading import Reading
from ntp_dsl.core.shown import Shown
from ntp_dsl.evaluation.episodes import Episode, Evaluator, Plan
from ntp_dsl.evaluation.statistics import calibration_error, statistics
from ntp_dsl.language.loader import load
from ntp_dsl.language.logic.list_contracts import parts_about
from ntp_dsl.language.registry import Registry
from ntp_dsl.policies.expert import Expert, NextCall
from ntp_dsl.policies.protocol import Barred, Choice, Frame
from ntp_dsl.semantics.observation import Argument, without_lists
from ntp_dsl.semantics.state import State
from ntp_dsl.tasks.instances import Instance
from ntp_dsl.worlds.protocol import Disturbances, World

DOMAINS = Path(__file__).parents[1] / "tests" / "evaluation" / "domains"
LARGE = {"crowded", "four_and_twenty", "many_objects", "four_and_twelve"}

Rows = dict[str, list[tuple[float, bool]]]  # of each kind: how probable it was found, and whether it was so


class Compared:
    """A policy beside the expert, who sees the truth and knows the lists."""

    def __init__(self, policy: OneShotPolicy, expert: Expert, rows: Rows) -> None:
        self.kind = policy.kind
        self._policy, self._expert, self._rows = policy, expert, rows
        self._given: dict[tuple[str, tuple[Any, ...]], tuple[Argument, ...]] = {}

    def root(self, program: str, arguments: tuple[Argument, ...]) -> Frame:
        self._given[program, without_lists(arguments)] = arguments
        return self._policy.root(program, arguments)

    def decide(self, frame: Frame, world: World, barred: Barred = frozenset()) -> Choice:
        choice = self._policy.decide(frame, world, barred)
        arguments = self._given.get((frame.program, without_lists(frame.arguments)), frame.arguments)
        takes_list = self._expert.registry.programs[frame.program].takes_list
        if barred or takes_list and arguments is frame.arguments:
            return choice
        right = self._expert.decide(frame.program, arguments, State(self._expert.registry, world.truth()))
        callee = right.callee if isinstance(right, NextCall) else None
        if isinstance(right, NextCall):
            self._given[right.callee, without_lists(right.arguments)] = right.arguments
        decision = choice.decision
        chances = {each.value: each.probability for each in decision.callees}
        if choice.callee in chances:
            self._rows["callee"].append((chances[choice.callee], choice.callee == callee))
        if decision.end_probability is not None:
            self._rows["end"].append((decision.end_probability, callee is None))
        if decision.probability is not None:
            same = choice.callee == callee and (
                not isinstance(right, NextCall) or _names(choice.arguments) == _names(right.arguments)
            )
            self._rows["decision"].append((decision.probability, same))
        return choice


def _names(arguments: tuple[Argument, ...]) -> tuple[str, ...]:
    return tuple(each for each in without_lists(arguments) if isinstance(each, str))


def _is_right(registry: Registry, instance: Instance, reading: Reading, start: State) -> bool:
    """Return whether lists have the elements that are meant: no others, and all that did not hold anyway.

    Numbers are not compared.
    """
    program = registry.programs[instance.program]
    lists = zip(program.parameters, reading.arguments, instance.arguments, strict=True)
    for parameter, read, meant in lists:
        if not isinstance(read, tuple) or not isinstance(meant, tuple):
            continue
        names = {_names((each,)) for each in read}
        if names - {_names((each,)) for each in meant}:
            return False
        for missing in (each for each in meant if _names((each,)) not in names):
            scope = {**program.bind(instance.arguments), parameter.name: (missing,)}
            said = parts_about(parameter.name, program.achieves)
            if not all(start.true(part, scope) for part in said):
                return False
    return True


def measure(arguments: argparse.Namespace) -> dict[str, Any]:
    """Return the calibration of decisions and readings, and how well confidence tells the failures."""
    torch.set_num_threads(1)
    rows: Rows = defaultdict(list)
    episodes: list[Episode] = []
    folders = [*examples_folder().iterdir(), *DOMAINS.iterdir()]
    tasks = [(each, task) for each in sorted(folders) if each.is_dir() for task in load(each).tasks]
    for library, task in tasks:
        if task in LARGE:
            continue
        disturbances = Disturbances(arguments.slips, 0.0, arguments.noise)
        plan = Plan(
            library,
            task,
            shipped_core(),
            seed=arguments.seed,
            disturbances=disturbances,
            demo_noise=arguments.noise,
        )
        evaluator = Evaluator(plan)
        for number in range(arguments.episodes):
            instance = evaluator.instance(number)
            recorded, _ = evaluator.demonstration(instance, number)
            policy = evaluator.policy(recorded)
            assert isinstance(policy, OneShotPolicy)
            source = policy.source
            assert isinstance(source, Shown)
            reading = source.reading(instance.program, instance.arguments, source.scope())
            start = State(evaluator.registry, source.look(0))
            is_right = _is_right(evaluator.registry, instance, reading, start)
            rows["list"].append((reading.probability, is_right))
            compared = Compared(policy, evaluator.expert, rows)
            episodes.append(evaluator.episode(number, recorded, policy=compared))
        wins = sum(bool(each.success) for each in episodes[-arguments.episodes :])
        print(f"{task}: {wins} of {arguments.episodes}", flush=True)
    figures = statistics(episodes, arguments.seed)
    return {
        "episodes": figures.episodes,
        "failed": sum(not each.success for each in episodes),
        "confidence": vars(figures.confidence) if figures.confidence else None,
        "calibration error": {kind: round(calibration_error(found), 4) for kind, found in rows.items()},
        "right": {
            kind: round(float(np.mean([each for _, each in found])), 4) for kind, found in rows.items()
        },
    }


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--episodes", type=int, default=10, help="of each task")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--noise", type=float, default=0.01, help="of looks and of the demonstration [m]")
    parser.add_argument("--slips", type=float, default=0.6)
    print(json.dumps(measure(parser.parse_args()), indent=1))


if __name__ == "__main__":
    main()
