"""Measures whether the one core knows what it has understood, where noise and slips make it fail.

python benchmarks/confidence.py --episodes 10 --noise 0.01 --slips 0.6
"""

from __future__ import annotations

import argparse
import json
from collections import defaultdict
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import torch

from ntp_dsl.common.resources import examples_folder
from ntp_dsl.core.one_core import shipped_core
from ntp_dsl.core.policy import OneShotPolicy
from ntp_dsl.core.reading.reading import Reading
from ntp_dsl.core.shown import Shown
from ntp_dsl.demonstrations.demonstration import Scope
from ntp_dsl.evaluation.episodes import Episode, Evaluator, Plan
from ntp_dsl.evaluation.statistics import statistics
from ntp_dsl.language.loader import load
from ntp_dsl.language.logic.list_contracts import parts_about
from ntp_dsl.language.registry import Registry
from ntp_dsl.policies.expert import Expert, NextCall, Return
from ntp_dsl.policies.protocol import Barred, Choice, Frame
from ntp_dsl.policies.scripted import like_calls
from ntp_dsl.semantics.observation import Argument, without_lists
from ntp_dsl.semantics.state import State
from ntp_dsl.tasks.instances import Instance
from ntp_dsl.traces.comparison.comparison_rules import overlap
from ntp_dsl.traces.report.reliability import Reliability
from ntp_dsl.traces.schema import DemonstratedCall
from ntp_dsl.worlds.protocol import Disturbances, World

DOMAINS = Path(__file__).parents[1] / "tests" / "evaluation" / "domains"
SAME_SCOPE = 0.5  # overlap of the frames from which a scope is right
LARGE = {"crowded", "four_and_twenty", "many_objects", "four_and_twelve"}

Rows = dict[str, list[tuple[float, bool]]]  # of each kind: how probable it was found, and whether it was so


class Compared:
    """A policy beside the expert, who sees the truth and knows the lists."""

    def __init__(self, policy: OneShotPolicy, expert: Expert, shown: DemonstratedCall, rows: Rows) -> None:
        self.kind = policy.kind
        self._policy, self._expert, self._rows = policy, expert, rows
        self._given: dict[tuple[str, tuple[Any, ...]], tuple[Argument, ...]] = {}
        root = shown.name, without_lists(shown.arguments), shown.scope
        self._shown: dict[tuple[str, tuple[Any, ...], Scope | None], DemonstratedCall] = {root: shown}

    def root(self, program: str, arguments: tuple[Argument, ...]) -> Frame:
        self._given[program, without_lists(arguments)] = arguments
        return self._policy.root(program, arguments)

    def right(self, program: str, arguments: tuple[Argument, ...], world: World) -> NextCall | Return | None:
        """Return what the expert would do in truth; None where the lists that are meant are not known."""
        given = self._given.get((program, without_lists(arguments)), arguments)
        if self._expert.registry.programs[program].takes_list and given is arguments:
            return None
        found = self._expert.decide(program, given, State(self._expert.registry, world.truth()))
        if isinstance(found, NextCall):
            self._given[found.callee, without_lists(found.arguments)] = found.arguments
        return found

    def decide(self, frame: Frame, world: World, barred: Barred = frozenset()) -> Choice:
        choice = self._policy.decide(frame, world, barred)
        self._compare_scope(frame, choice)
        right = None if barred else self.right(frame.program, frame.arguments, world)
        if right is None:
            return choice
        callee = right.callee if isinstance(right, NextCall) else None
        decision = choice.decision
        chances = {each.value: each.probability for each in decision.callees}
        if choice.callee in chances:
            self._rows["callee"].append((chances[choice.callee], choice.callee == callee))
        if isinstance(right, NextCall) and choice.callee == callee:
            values = without_lists(right.arguments)
            for ranking, value in zip(decision.arguments, values, strict=False):
                if ranking and isinstance(value, str):
                    chance = ranking[0].probability / chances[choice.callee or ""]
                    self._rows["argument"].append((min(1.0, chance), ranking[0].value == value))
        if decision.end_probability is not None:
            self._rows["end"].append((decision.end_probability, callee is None))
        if decision.probability is not None:
            same = choice.callee == callee and (
                not isinstance(right, NextCall) or names_of(choice.arguments) == names_of(right.arguments)
            )
            self._rows["decision"].append((decision.probability, same))
        return choice

    def _compare_scope(self, frame: Frame, choice: Choice) -> None:
        """Hold the scope of a call against that of the expert's own."""
        caller = self._shown.get((frame.program, without_lists(frame.arguments), frame.scope))
        if caller is None or choice.callee is None or choice.scope is None:
            return
        calls = [each for each in like_calls(caller, choice.callee, choice.arguments) if each.done]
        if calls:
            self._shown[choice.callee, without_lists(choice.arguments), choice.scope] = calls[-1]
            is_right = overlap(choice.scope, calls[-1].scope) >= SAME_SCOPE
            self._rows["scope"].append((float(choice.matched), is_right))


def names_of(arguments: tuple[Argument, ...]) -> tuple[str, ...]:
    return tuple(each for each in without_lists(arguments) if isinstance(each, str))


def _is_right(registry: Registry, instance: Instance, reading: Reading, start: State, end: State) -> bool:
    """Return whether lists have the elements that are meant: no others, and all that did not hold anyway.

    Numbers count as right where the program's contract holds at the end with the lists that were read.

    Args:
        start: of the demonstration, as it is seen.
        end: of the demonstration, in truth.
    """
    program = registry.programs[instance.program]
    if not end.true(program.achieves, program.bind(reading.arguments)):
        return False
    lists = zip(program.parameters, reading.arguments, instance.arguments, strict=True)
    for parameter, read, meant in lists:
        if not isinstance(read, tuple) or not isinstance(meant, tuple):
            continue
        names = {names_of((each,)) for each in read}
        if names - {names_of((each,)) for each in meant}:
            return False
        for missing in (each for each in meant if names_of((each,)) not in names):
            scope = {**program.bind(instance.arguments), parameter.name: (missing,)}
            said = parts_about(parameter.name, program.achieves)
            if not all(start.true(part, scope) for part in said):
                return False
    return True


def tasks() -> list[tuple[Path, str]]:
    """Return the libraries and tasks that are measured: all but the largest."""
    folders = [each for each in (*examples_folder().iterdir(), *DOMAINS.iterdir()) if each.is_dir()]
    return [(each, task) for each in sorted(folders) for task in load(each).tasks if task not in LARGE]


def _end(evaluator: Evaluator, instance: Instance, number: int) -> State:
    """Return the last state that a demonstration shows, without noise."""
    clean = Evaluator(replace(evaluator.plan, demo_noise=0.0))
    recorded, _ = clean.demonstration(instance, number)
    policy = clean.policy(recorded)
    assert isinstance(policy, OneShotPolicy) and isinstance(policy.source, Shown)
    return State(clean.registry, policy.source.look(len(recorded.demonstration) - 1))


def evaluator_of(library: Path, task: str, arguments: argparse.Namespace) -> Evaluator:
    disturbances = Disturbances(arguments.slips, 0.0, arguments.noise)
    return Evaluator(
        Plan(
            library,
            task,
            arguments.model or shipped_core(),
            seed=arguments.seed,
            disturbances=disturbances,
            demo_noise=arguments.noise,
        )
    )


def measure(arguments: argparse.Namespace) -> dict[str, Any]:
    """Return the calibration of decisions and readings, and how well confidence tells the failures."""
    torch.set_num_threads(1)
    rows: Rows = defaultdict(list)
    episodes: list[Episode] = []
    for library, task in tasks():
        evaluator = evaluator_of(library, task, arguments)
        for number in range(arguments.episodes):
            instance = evaluator.instance(number)
            recorded, _ = evaluator.demonstration(instance, number)
            policy = evaluator.policy(recorded)
            assert isinstance(policy, OneShotPolicy) and isinstance(policy.source, Shown)
            source = policy.source
            reading = source.reading(instance.program, instance.arguments, source.scope())
            start = State(evaluator.registry, source.look(0))
            end = _end(evaluator, instance, number)
            rows["list"].append(
                (reading.probability, _is_right(evaluator.registry, instance, reading, start, end))
            )
            assert recorded.calls is not None
            compared = Compared(policy, evaluator.expert, recorded.calls, rows)
            episodes.append(evaluator.episode(number, recorded, policy=compared))
        wins = sum(bool(each.success) for each in episodes[-arguments.episodes :])
        print(f"{task}: {wins} of {arguments.episodes}", flush=True)
    figures = statistics(episodes, arguments.seed)
    return {
        "episodes": figures.episodes,
        "failed": sum(not each.success for each in episodes),
        "confidence": vars(figures.confidence) if figures.confidence else None,
        "calibration error": {kind: round(Reliability.of(found).error, 4) for kind, found in rows.items()},
        "right": {
            kind: round(float(np.mean([each for _, each in found])), 4) for kind, found in rows.items()
        },
    }


def parser(description: str | None) -> argparse.ArgumentParser:
    found = argparse.ArgumentParser(description=description, formatter_class=argparse.RawTextHelpFormatter)
    found.add_argument("--episodes", type=int, default=10, help="of each task")
    found.add_argument("--seed", type=int, default=0)
    found.add_argument("--noise", type=float, default=0.01, help="of looks and of the demonstration [m]")
    found.add_argument("--slips", type=float, default=0.6)
    found.add_argument("--model", type=Path, default=None, help="a core of `ntp pretrain`")
    return found


if __name__ == "__main__":
    print(json.dumps(measure(parser(__doc__).parse_args()), indent=1))
