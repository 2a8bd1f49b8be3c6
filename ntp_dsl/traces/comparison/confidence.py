"""Confidence of a learned decision: its probability of the choice that it made, and of the right one."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from operator import eq

from ntp_dsl.semantics.observation import without_lists
from ntp_dsl.traces.comparison.comparison_rules import MIN_SCOPE_OVERLAP, DivergenceKind, overlap
from ntp_dsl.traces.decision import Decision, Ranking, Value
from ntp_dsl.traces.schema import Call


@dataclass(frozen=True)
class Confidence:
    """Probabilities of the part of a decision in which two traces differ; None where it has none."""

    chosen: float | None = None  # probability of the choice
    right: float | None = None  # probability of the right one; None where it is not among the alternatives
    rank: int | None = None  # of the right one among the alternatives, from 1

    @property
    def margin(self) -> float | None:
        """Return the probability of the choice minus that of the right one."""
        return None if self.chosen is None else round(self.chosen - (self.right or 0.0), 4)


UNKNOWN = Confidence()


def confidence(kind: DivergenceKind, decision: Decision | None, x: Call | None, y: Call | None) -> Confidence:
    """Return the confidence of the decision to make y where x was right; None stands for a return."""
    if decision is None:
        return UNKNOWN
    if x is None or y is None:
        return _of_end(decision.end_probability, returned=y is None)
    match kind:
        case DivergenceKind.PROGRAM:
            return _ranked(decision.callees, partial(eq, x.name), partial(eq, y.name))
        case DivergenceKind.ARGUMENT:
            return _of_argument(decision, x, y)
        case DivergenceKind.SCOPE:
            right = x.scope
            return _ranked(
                decision.scopes,
                lambda scope: overlap(scope, right) >= MIN_SCOPE_OVERLAP,
                partial(eq, y.scope),
            )
    return UNKNOWN


def _of_end(probability: float | None, returned: bool) -> Confidence:
    if probability is None:
        return UNKNOWN
    chosen = probability if returned else 1 - probability
    right = 1 - chosen
    return Confidence(round(chosen, 4), round(right, 4), 1 if right > chosen else 2)


def _of_argument(decision: Decision, x: Call, y: Call) -> Confidence:
    """Return the confidence in the first argument that differs: an object, a member or a number."""
    right, chosen = without_lists(x.arguments), without_lists(y.arguments)
    for expected, actual, ranking in zip(right, chosen, decision.arguments, strict=False):
        if expected != actual:
            return _ranked(ranking, partial(eq, expected), partial(eq, actual))
    return UNKNOWN


def _ranked(
    ranking: Ranking[Value], is_right: Callable[[Value], bool], is_chosen: Callable[[Value], bool]
) -> Confidence:
    right = next((place for place, each in enumerate(ranking) if is_right(each.value)), None)
    chosen = next((each.probability for each in ranking if is_chosen(each.value)), None)
    if right is None:
        return Confidence(chosen)
    return Confidence(chosen, ranking[right].probability, right + 1)
