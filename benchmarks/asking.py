"""Measures what asking brings: failures, and questions, where whoever is asked knows the truth.

python benchmarks/asking.py --episodes 10 --below 0.5 0.7 0.9
"""

from __future__ import annotations

import argparse
import json
from collections import defaultdict
from dataclasses import dataclass
from typing import Any

import torch
from confidence import Compared, evaluator_of, names_of, parser, tasks

from ntp_dsl.core.asking import Asking, Question
from ntp_dsl.core.policy import OneShotPolicy
from ntp_dsl.core.reading.reading import Doubt
from ntp_dsl.core.shown import Shown
from ntp_dsl.datasets.recording import RecordedDemonstration
from ntp_dsl.evaluation.episodes import Evaluator
from ntp_dsl.language.diagnostics.diagnostics import NtpError
from ntp_dsl.policies.expert import NextCall
from ntp_dsl.semantics.observation import Record
from ntp_dsl.tasks.instances import Instance


@dataclass
class Knowing:
    """Whoever is asked: answers by the truth, where that is among what is offered, and else the first."""

    evaluator: Evaluator
    compared: Compared
    asked: int = 0

    def decision(self, question: Question) -> int:
        self.asked += 1
        right = self.compared.right(question.program, question.arguments, self.evaluator.world)
        if right is None:  # it is not known which lists are meant
            return 0
        wanted = (right.callee, names_of(right.arguments)) if isinstance(right, NextCall) else (None, ())
        offered = [(each.callee, names_of(each.arguments)) for each in question.options]
        return offered.index(wanted) if wanted in offered else 0

    def elements(self, instance: Instance, doubts: list[Doubt]) -> dict[Doubt, Record | str]:
        self.asked += len(doubts)
        program = self.evaluator.registry.programs[instance.program]
        lists = dict(zip((each.name for each in program.parameters), instance.arguments, strict=True))
        meant: dict[Doubt, Record | str] = {}
        for doubt in doubts:
            elements = lists[doubt.parameter]
            assert isinstance(elements, tuple)
            names = {names_of((each,)) for each in elements}
            right = [each for each, _ in ((doubt.element, 0.0), *doubt.others) if names_of((each,)) in names]
            if right:
                meant[doubt] = right[0]
        return meant


def run(
    evaluator: Evaluator,
    number: int,
    recorded: RecordedDemonstration,
    below: float,
    calls_below: float,
) -> tuple[bool, int]:
    """Return whether an episode succeeds, and how many questions were asked."""
    instance = evaluator.instance(number)
    policy = evaluator.policy(recorded)
    assert isinstance(policy, OneShotPolicy) and isinstance(policy.source, Shown)
    assert recorded.calls is not None
    compared = Compared(policy, evaluator.expert, recorded.calls, defaultdict(list))
    knowing = Knowing(evaluator, compared)
    if below:
        source = policy.source
        wanted = instance.program, instance.arguments, source.scope()
        doubts = [each for each in source.reading(*wanted).doubts if each.probability < below]
        if meant := knowing.elements(instance, doubts):
            try:
                source.settle(*wanted, meant)
            except NtpError as error:  # together they explain less
                print(error)
        policy.adviser = Asking(knowing.decision, below, calls_below)
    episode = evaluator.episode(number, recorded, policy=compared)
    return bool(episode.success), knowing.asked


def measure(arguments: argparse.Namespace) -> dict[str, Any]:
    """Return, for each threshold, how many episodes fail, and how many successes had a question."""
    torch.set_num_threads(1)
    outcomes: dict[float, list[tuple[bool, int]]] = defaultdict(list)
    for library, task in tasks():
        evaluator = evaluator_of(library, task, arguments)
        for number in range(arguments.episodes):
            recorded, _ = evaluator.demonstration(evaluator.instance(number), number)
            for below in (0.0, *arguments.below):
                outcomes[below].append(run(evaluator, number, recorded, below, arguments.calls_below))
        last = {below: outcomes[below][-arguments.episodes :] for below in outcomes}
        print(task, {below: sum(won for won, _ in some) for below, some in last.items()}, flush=True)
    return {
        f"asked below {below}": {
            "episodes": len(some),
            "failed": sum(not won for won, _ in some),
            "successes with a question": round(
                sum(won and asked > 0 for won, asked in some) / max(1, sum(won for won, _ in some)), 4
            ),
        }
        for below, some in outcomes.items()
    }


if __name__ == "__main__":
    found = parser(__doc__)
    found.add_argument("--below", type=float, nargs="+", default=[0.5, 0.7, 0.9])
    found.add_argument("--calls-below", type=float, default=0.0, help="asks about calls as well")
    print(json.dumps(measure(found.parse_args()), indent=1))
