"""The learnt dispatcher: a query over keys of calls, trained where the truth is uncertain."""

from __future__ import annotations

import dataclasses
import heapq
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TypeVar

import torch
from msgspec.structs import replace
from torch import Tensor

from ntp_dsl.core.dispatch.dispatcher import Dispatched, Situation
from ntp_dsl.core.dispatch.network import DispatchNetwork, batched, first_hit
from ntp_dsl.core.dispatch.rows import Key, Row, unrolled
from ntp_dsl.core.dispatch.rule import RuleDispatcher
from ntp_dsl.core.learnt.preferences import Preference, columns_of
from ntp_dsl.core.learnt.quantities import quantities
from ntp_dsl.core.perception.perceived import Believed
from ntp_dsl.language.registry import Program
from ntp_dsl.policies.evidence import rounded, weighed
from ntp_dsl.policies.expert import Expert, NextCall, Return
from ntp_dsl.policies.left_out import told_evidence
from ntp_dsl.policies.protocol import Barred
from ntp_dsl.policies.scripted import source_of
from ntp_dsl.semantics.observation import Argument, without_lists
from ntp_dsl.traces.decision import Alternative, Decision, Ranking

Value = TypeVar("Value", bound=str | float)

TOP = 5  # alternatives that a decision reports
LEAST = 0.005  # probability from which they are


class LearnedDispatcher:
    """Decides by a network over a program's row; what has no row is left to the rule.

    Where a return is barred, as at a program's first step, the most probable call is made, however
    improbable: its caller made sure that there is something to do. The probability of a decision is that
    among what is not barred, averaged over where objects may be.
    """

    def __init__(
        self, expert: Expert, network: DispatchNetwork, preferences: Mapping[str, Preference] | None = None
    ) -> None:
        self._expert, self._network, self._rule = expert, network, RuleDispatcher(expert)
        self._preferences = preferences or {}

    def dispatch(self, situations: Sequence[Situation]) -> list[Dispatched]:
        programs = [self._expert.registry.programs[each.program] for each in situations]
        variants = [
            [] if program.in_python else self._variants(program, each.arguments, each.state)
            for program, each in zip(programs, situations, strict=True)
        ]
        answers = iter(self._answers([case for some in variants for case in some]))
        return [
            self._dispatched(each, [(case.weight, next(answers)) for case in some])
            if some
            else self._rule.dispatch([each])[0]
            for each, some in zip(situations, variants, strict=True)
        ]

    def _variants(self, program: Program, arguments: tuple[Argument, ...], state: Believed) -> list[_Case]:
        """Return a program's row as things are seen, by which is decided, and those that may be.

        Each has its probability: the first one 0, where there are others.
        """
        seen = self._case(1.0, program, arguments, state)
        variants = state.variants(seen.row.facts)
        if variants[0][1] is state:
            return [seen]
        others = [self._case(weight, program, arguments, each) for weight, each in variants]
        return [dataclasses.replace(seen, weight=0.0), *others]

    def _case(
        self, weight: float, program: Program, arguments: tuple[Argument, ...], state: Believed
    ) -> _Case:
        row = unrolled(program, arguments, state)
        preference = self._preferences.get(program.name)
        if preference is None or not preference.terms:
            return _Case(weight, row)
        return _Case(weight, row, _scores(preference, row, state))

    def _dispatched(self, situation: Situation, variants: Sequence[tuple[float, _Answer]]) -> Dispatched:
        barred = situation.barred
        seen, expected = variants[0][1], _expected(variants)
        allowed = seen.allowed(barred)
        if None in barred:  # there is something to do, though it be not what is seen
            likely = [expected.chance(key) for key in seen.row.keys]
            likely = [chance if had > 0 else 0.0 for chance, had in zip(likely, allowed, strict=True)]
            allowed = likely if any(likely) else allowed
        best = max(range(len(allowed)), key=allowed.__getitem__, default=None)
        ends = best is None or allowed[best] <= 0 or (seen.end >= allowed[best] and None not in barred)
        end = Return(seen.row.achievement > 0.5)
        answer = end if ends or best is None else seen.row.calls[best]
        own = None if ends or best is None else seen.row.keys[best]
        options: list[tuple[NextCall | Return, float]] = [
            (call, chance)
            for key, (call, chance) in expected.calls.items()
            if call.callee not in barred and key != own and call != answer
        ]
        options += [(end, expected.end)] * (own is not None and None not in barred)
        chance = expected.end if own is None else expected.chance(own)
        possible = chance + sum(each for _, each in options)
        others = tuple(
            (each, share / possible)
            for each, share in heapq.nlargest(TOP, options, key=lambda option: option[1])
            if possible and share / possible > LEAST
        )
        program = self._expert.registry.programs[situation.program]
        is_unfinished = isinstance(answer, Return) and not answer.done
        grounds, statements = told_evidence(
            self._expert, program, situation.arguments, situation.state, is_unfinished
        )
        calls = [call for call, _ in expected.calls.values()]
        chances = [each for _, each in expected.calls.values()]
        decision = Decision(
            probability=rounded(chance / possible if possible else 1.0),
            end_probability=rounded(expected.end),
            callees=_ranked([call.callee for call in calls], chances),
            facts=weighed(grounds, situation.state.probability),
            statements=statements,
        )
        if isinstance(answer, NextCall):
            decision = _with_call(decision, answer, calls, chances)
        achieved = sum(weight * each.row.achievement for weight, each in variants)
        return Dispatched(answer, decision, achieved, grounds, others)

    @torch.inference_mode()
    def _answers(self, cases: Sequence[_Case]) -> list[_Answer]:
        rows = [each.row for each in cases]
        if not any(row.calls for row in rows):
            return [_Answer(row, [], 1.0) for row in rows]
        hazards = self._network.hazards(batched(rows))
        calls, ends = first_hit(hazards)
        answers = zip(cases, hazards, calls.exp().tolist(), ends.exp().tolist(), strict=True)
        return [
            _Answer(case.row, case.preferring(due, chances[: len(case.row.calls)], end), end)
            if case.row.calls
            else _Answer(case.row, [], 1.0)
            for case, due, chances, end in answers
        ]


def _scores(preference: Preference, row: Row, state: Believed) -> tuple[float, ...]:
    """Return the score of each call of a row."""
    calls = zip(row.calls, row.statements, strict=True)
    wanted = preference.quantities
    return tuple(
        preference.score(columns_of(quantities(call, statement, state, wanted), call.callee))
        for call, statement in calls
    )


@dataclass(frozen=True)
class _Case:
    """A row, how probably things are so, and the score of each call where a preference is known."""

    weight: float
    row: Row
    scores: tuple[float, ...] = ()

    def preferring(self, hazards: Tensor, chances: list[float], end: float) -> list[float]:
        """Return the chances of the calls: with a preference, of those that are due, by their scores."""
        due = hazards[: len(chances)] > 0
        if not self.scores or not due.any():
            return chances
        scores = torch.tensor(self.scores).masked_fill(~due, -torch.inf)
        return (scores.softmax(0) * (1 - end)).tolist()


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


@dataclass(frozen=True)
class _Expected:
    """Answers over all that may be: each call with its probability, and that of the end."""

    calls: dict[Key, tuple[NextCall, float]]
    end: float

    def chance(self, key: Key) -> float:
        return self.calls[key][1]


def _expected(variants: Sequence[tuple[float, _Answer]]) -> _Expected:
    """Return the mean of answers. Calls are those of the first one, as far as it has them."""
    calls: dict[Key, tuple[NextCall, float]] = {}
    for weight, answer in variants:
        for key, call, chance in zip(answer.row.keys, answer.row.calls, answer.chances, strict=True):
            first, so_far = calls.get(key, (call, 0.0))
            calls[key] = first, so_far + weight * chance
    return _Expected(calls, sum(weight * answer.end for weight, answer in variants))


def _with_call(
    decision: Decision, call: NextCall, calls: Sequence[NextCall], chances: Sequence[float]
) -> Decision:
    same = [(each, chance) for each, chance in zip(calls, chances, strict=True) if each.callee == call.callee]
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
