"""The learnt dispatcher: a query over keys of calls, trained where the truth is uncertain."""

from __future__ import annotations

import heapq
from collections.abc import Sequence
from typing import TypeVar

import torch
from msgspec.structs import replace

from ntp_dsl.core.dispatch.dispatcher import Dispatched, Situation
from ntp_dsl.core.dispatch.evidence import evidence, rounded
from ntp_dsl.core.dispatch.network import DispatchNetwork, batched
from ntp_dsl.core.dispatch.rows import Row, unrolled
from ntp_dsl.core.dispatch.rule import RuleDispatcher
from ntp_dsl.policies.expert import Expert, NextCall, Return
from ntp_dsl.policies.scripted import source_of
from ntp_dsl.semantics.observation import without_lists
from ntp_dsl.traces.decision import Alternative, Decision, Ranking

Value = TypeVar("Value", bound=str | float)

Chances = tuple[list[float], float]  # how probable each call of a row is, and the end

TOP = 5  # alternatives that a decision reports


class LearnedDispatcher:
    """Decides by a network over a program's row; what has no row is left to the rule.

    Where a return is barred, as at a program's first step, the most probable call is made, however
    improbable: its caller made sure that there is something to do. The probability of a decision is that
    among what is not barred.
    """

    def __init__(self, expert: Expert, network: DispatchNetwork) -> None:
        self._expert, self._network, self._rule = expert, network, RuleDispatcher(expert)

    def dispatch(self, situations: Sequence[Situation]) -> list[Dispatched]:
        registry = self._expert.registry
        rows = [
            None
            if (program := registry.programs[each.program]).in_python
            else unrolled(registry, program, each.arguments, each.state)
            for each in situations
        ]
        chances = iter(self._chances([row for row in rows if row is not None]))
        return [
            self._rule.dispatch([each])[0] if row is None else self._dispatched(each, row, *next(chances))
            for each, row in zip(situations, rows, strict=True)
        ]

    def _dispatched(self, situation: Situation, row: Row, chances: list[float], end: float) -> Dispatched:
        allowed = [
            0.0 if call.callee in situation.barred else chance
            for call, chance in zip(row.calls, chances, strict=True)
        ]
        best = max(range(len(allowed)), key=allowed.__getitem__, default=None)
        ends = best is None or allowed[best] <= 0 or (end >= allowed[best] and None not in situation.barred)
        possible = sum(allowed) + (0.0 if None in situation.barred else end)
        weight = end if ends or best is None else allowed[best]
        chance = weight / possible if possible else 1.0
        program = self._expert.registry.programs[situation.program]
        facts, statements = evidence(self._expert, program, situation.arguments, situation.state)
        decision = Decision(
            probability=rounded(chance),
            end_probability=rounded(end),
            callees=_ranked([call.callee for call in row.calls], chances),
            facts=facts,
            statements=statements,
        )
        achieved = min((float(row.probabilities[at]) for at in row.achieved), default=1.0)
        if ends or best is None:
            return Dispatched(Return(achieved > 0.5), decision, achieved)
        call = row.calls[best]
        return Dispatched(call, _with_call(decision, call, row, chances), achieved)

    @torch.inference_mode()
    def _chances(self, rows: Sequence[Row]) -> list[Chances]:
        """Return how probable each call of each row is, and the end."""
        if not any(row.calls for row in rows):
            return [([], 1.0) for _ in rows]
        calls, ends = self._network(batched(rows))
        pairs = zip(rows, calls.exp().tolist(), ends.exp().tolist(), strict=True)
        return [(chances[: len(row.calls)], end) if row.calls else ([], 1.0) for row, chances, end in pairs]


def _with_call(decision: Decision, call: NextCall, row: Row, chances: list[float]) -> Decision:
    same = [(each, c) for each, c in zip(row.calls, chances, strict=True) if each.callee == call.callee]
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
