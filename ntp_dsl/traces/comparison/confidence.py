"""How sure a learned decision was of what it did, and of what would have been right."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from operator import eq

from ntp_dsl.semantics.observation import without_lists
from ntp_dsl.traces.comparison.comparison_rules import OVERLAP, Kind, overlap
from ntp_dsl.traces.decision import Decision, Ranking, Value
from ntp_dsl.traces.schema import Call


@dataclass(frozen=True)
class Confidence:
    """Of the part of a decision in which two traces differ; all None where nobody weighed anything."""

    chosen: float | None = None  # probability
    right: float | None = None  # None where it is not among the alternatives that are kept
    rank: int | None = None  # of the right one among them, from 1

    @property
    def margin(self) -> float | None:
        """Return how much surer it was of what it did than of what was right."""
        return None if self.chosen is None else round(self.chosen - (self.right or 0.0), 4)


UNKNOWN = Confidence()


def confidence(kind: Kind, decision: Decision | None, x: Call | None, y: Call | None) -> Confidence:
    """Return how sure the decision was that led to y, or to a return where y is None; x was right."""
    if decision is None:
        return UNKNOWN
    if x is None or y is None:
        return _of_end(decision.end_probability, returned=y is None)
    match kind:
        case Kind.PROGRAM:
            return _ranked(decision.callees, partial(eq, x.name), partial(eq, y.name))
        case Kind.ARGUMENT:
            return _of_argument(decision, x, y)
        case Kind.SCOPE:
            right = x.scope
            return _ranked(
                decision.scopes, lambda scope: overlap(scope, right) >= OVERLAP, partial(eq, y.scope)
            )
    return UNKNOWN


def _of_end(probability: float | None, returned: bool) -> Confidence:
    if probability is None:
        return UNKNOWN
    chosen = probability if returned else 1 - probability
    right = 1 - chosen
    return Confidence(round(chosen, 4), round(right, 4), 1 if right > chosen else 2)


def _of_argument(decision: Decision, x: Call, y: Call) -> Confidence:
    """Return that of the first argument that differs: an object, a member or a number."""
    right, chosen = without_lists(x.arguments), without_lists(y.arguments)
    for wanted, made, ranking in zip(right, chosen, decision.arguments, strict=False):
        if wanted != made:
            return _ranked(ranking, partial(eq, wanted), partial(eq, made))
    return UNKNOWN


def _ranked(
    ranking: Ranking[Value], is_right: Callable[[Value], bool], is_chosen: Callable[[Value], bool]
) -> Confidence:
    right = next((place for place, each in enumerate(ranking) if is_right(each.value)), None)
    chosen = next((each.probability for each in ranking if is_chosen(each.value)), None)
    if right is None:
        return Confidence(chosen)
    return Confidence(chosen, ranking[right].probability, right + 1)
