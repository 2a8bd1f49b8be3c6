"""The learnt dispatcher: a query over keys of calls, trained where the truth is uncertain."""

from __future__ import annotations

import heapq
from collections import Counter, defaultdict
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypeVar

import torch
from msgspec.structs import replace

from ntp_dsl.core.dispatch.dispatcher import Dispatched, Situation
from ntp_dsl.core.dispatch.network import DispatchNetwork, batched
from ntp_dsl.core.dispatch.rows import Row, unrolled
from ntp_dsl.core.dispatch.rule import RuleDispatcher
from ntp_dsl.core.perception.perceived import Believed
from ntp_dsl.language.registry import Program
from ntp_dsl.policies.evidence import evidence, rounded, weighed
from ntp_dsl.policies.expert import Expert, NextCall, Return
from ntp_dsl.policies.protocol import Barred
from ntp_dsl.policies.scripted import source_of
from ntp_dsl.semantics.observation import Argument, without_lists
from ntp_dsl.traces.decision import Alternative, Decision, Ranking

Value = TypeVar("Value", bound=str | float)

TOP = 5  # alternatives that a decision reports
LEAST = 0.005  # probable of them


class LearnedDispatcher:
    """Decides by a network over a program's row; what has no row is left to the rule.

    Where a return is barred, as at a program's first step, the most probable call is made, however
    improbable: its caller made sure that there is something to do. The probability of a decision is that
    among what is not barred, over all that may be as far as objects are seen.
    """

    def __init__(self, expert: Expert, network: DispatchNetwork) -> None:
        self._expert, self._network, self._rule = expert, network, RuleDispatcher(expert)

    def dispatch(self, situations: Sequence[Situation]) -> list[Dispatched]:
        programs = [self._expert.registry.programs[each.program] for each in situations]
        variants = [
            [] if program.in_python else self._variants(program, each.arguments, each.state)
            for program, each in zip(programs, situations, strict=True)
        ]
        answers = iter(self._answers([row for some in variants for _, row in some]))
        return [
            self._dispatched(each, [(weight, next(answers)) for weight, _ in some])
            if some
            else self._rule.dispatch([each])[0]
            for each, some in zip(situations, variants, strict=True)
        ]

    def _variants(
        self, program: Program, arguments: tuple[Argument, ...], state: Believed
    ) -> list[tuple[float, Row]]:
        """Return a program's row, first as things are seen, and each that may be, with its probability."""
        row = unrolled(self._expert.registry, program, arguments, state)
        variants = state.variants(row.facts)
        if len(variants) == 1:
            return [(1.0, row)]
        others = [(w, unrolled(self._expert.registry, program, arguments, each)) for w, each in variants]
        return [(0.0, row), *others]

    def _dispatched(self, situation: Situation, variants: Sequence[tuple[float, _Answer]]) -> Dispatched:
        barred = situation.barred
        seen, expected = variants[0][1], _expected(variants)
        among = expected.allowed(barred)
        allowed = among if None in barred else seen.allowed(barred)
        best = max(range(len(allowed)), key=allowed.__getitem__, default=None)
        ends = best is None or allowed[best] <= 0 or (seen.end >= allowed[best] and None not in barred)
        end = Return(seen.row.achievement > 0.5)
        answer = end if ends or best is None else seen.row.calls[best]
        options: list[tuple[NextCall | Return, float]] = [*zip(seen.row.calls, among, strict=True)]
        options += [(end, 0.0 if None in barred else expected.end)]
        possible = sum(chance for _, chance in options)
        others = tuple(
            (each, chance / possible)
            for each, chance in heapq.nlargest(TOP, options, key=lambda option: option[1])
            if each != answer and chance > LEAST
        )
        chance = expected.end if ends or best is None else among[best]
        program = self._expert.registry.programs[situation.program]
        grounds, statements = evidence(self._expert, program, situation.arguments, situation.state)
        decision = Decision(
            probability=rounded(chance / possible if possible else 1.0),
            end_probability=rounded(expected.end),
            callees=_ranked([call.callee for call in expected.row.calls], expected.chances),
            facts=weighed(grounds, situation.state.probability),
            statements=statements,
        )
        if isinstance(answer, NextCall):
            decision = _with_call(decision, answer, expected)
        achieved = sum(weight * each.row.achievement for weight, each in variants)
        return Dispatched(answer, decision, achieved, grounds, others)

    @torch.inference_mode()
    def _answers(self, rows: Sequence[Row]) -> list[_Answer]:
        if not any(row.calls for row in rows):
            return [_Answer(row, [], 1.0) for row in rows]
        calls, ends = self._network(batched(rows))
        answers = zip(rows, calls.exp().tolist(), ends.exp().tolist(), strict=True)
        return [
            _Answer(row, chances[: len(row.calls)], end) if row.calls else _Answer(row, [], 1.0)
            for row, chances, end in answers
        ]


@dataclass(frozen=True)
class _Answer:
    """What the network says of a row: how probable each call is, and the end."""

    row: Row
    chances: list[float]
    end: float

    def allowed(self, barred: Barred) -> list[float]:
        """Return how probable each call is; zero for those of barred callees."""
        pairs = zip(self.row.calls, self.chances, strict=True)
        return [0.0 if call.callee in barred else chance for call, chance in pairs]


def _expected(variants: Sequence[tuple[float, _Answer]]) -> _Answer:
    """Return the answer over all variants, as one to the first."""
    if len(variants) == 1:
        return variants[0][1]
    chances: dict[NextCall, float] = defaultdict(float)
    for weight, answer in variants:
        for call, chance in zip(answer.row.calls, answer.chances, strict=True):
            chances[call] += weight * chance
    row = variants[0][1].row
    times = Counter(row.calls)  # a call that is there twice is as probable both times
    return _Answer(
        row,
        [chances[call] / times[call] for call in row.calls],
        sum(weight * each.end for weight, each in variants),
    )


def _with_call(decision: Decision, call: NextCall, answer: _Answer) -> Decision:
    pairs = zip(answer.row.calls, answer.chances, strict=True)
    same = [(each, chance) for each, chance in pairs if each.callee == call.callee]
    given = [without_lists(each.arguments) for each, _ in same]
    arguments = tuple(
        _ranked([values[place] for values in given], [c for _, c in same])
        for place in range(len(without_lists(call.arguments)))
    )
    return replace(decision, source=source_of(call), arguments=arguments)


def _ranked(values: Sequence[Value], chances: Sequence[float]) -> Ranking[Value]:
    """Return the most probable values first, each with all of its probability."""
    total: dict[Value, float] = {}
    for value, chance in zip(values, chances, strict=True):
        total[value] = total.get(value, 0.0) + chance
    best = heapq.nlargest(TOP, total.items(), key=lambda each: each[1])
    return tuple(Alternative(value, rounded(chance)) for value, chance in best if chance >= 0.00005)
