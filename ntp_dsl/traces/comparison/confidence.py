"""How sure a learned decision was of what it did, and of what would have been right."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial
from operator import eq
from typing import Any

from ntp_dsl.semantics.observation import Argument
from ntp_dsl.traces.comparison.comparison_rules import OVERLAP, Kind, overlap
from ntp_dsl.traces.schema import Call


@dataclass(frozen=True)
class Certainty:
    """Of the part of a decision in which two traces differ; all None where nobody weighed anything."""

    chosen: float | None = None  # probability
    right: float | None = None  # None where it is not among the alternatives that are kept
    rank: int | None = None  # of the right one among them, from 1

    @property
    def margin(self) -> float | None:
        """How much surer it was of what it did than of what was right."""
        return None if self.chosen is None else round(self.chosen - (self.right or 0.0), 4)


UNKNOWN = Certainty()


def certainty(kind: Kind, decision: Mapping[str, Any], x: Call | None, y: Call | None) -> Certainty:
    """`decision` is the one that led to y, or to a return where y is None; x is what was right."""
    try:
        if x is None or y is None:
            return _end(float(decision["end_probability"]), returned=y is None)
        if kind is Kind.PROGRAM:
            return _ranked(decision["top"], lambda name: name == x.name, lambda name: name == y.name)
        if kind is Kind.ARGUMENT:
            return _argument(decision, x, y)
        if kind is Kind.SCOPE:
            right, chosen = x.scope, y.scope
            return _ranked(
                decision["scopes"],
                lambda scope: overlap(_scope(scope), right) >= OVERLAP,
                lambda scope: _scope(scope) == chosen,
            )
    except (KeyError, TypeError, ValueError, IndexError):
        pass  # a decision that says nothing of its alternatives, or not in words that are known
    return UNKNOWN


def _end(probability: float, returned: bool) -> Certainty:
    chosen = probability if returned else 1 - probability
    right = 1 - chosen
    return Certainty(round(chosen, 4), round(right, 4), 1 if right > chosen else 2)


def _argument(decision: Mapping[str, Any], x: Call, y: Call) -> Certainty:
    """Of the first argument that differs: an object, a member or a number."""
    right, chosen = (_without_lists(call) for call in (x, y))
    rankings = _rankings(decision, chosen)
    for wanted, made, ranking in zip(right, chosen, rankings, strict=True):
        if wanted != made:
            return _ranked(ranking, partial(eq, wanted), partial(eq, made))
    return UNKNOWN


def _without_lists(call: Call) -> list[Argument]:
    return [argument for argument in call.arguments if not isinstance(argument, tuple)]


def _rankings(decision: Mapping[str, Any], chosen: list[Argument]) -> list[Any]:
    """For each argument its own: objects and values are ranked apart, each in the arguments' order."""
    waiting = [list(decision.get("pointers", ())), list(decision.get("values", ()))]
    found = []
    for argument in chosen:
        kind = next((kind for kind in waiting if kind and kind[0][0][0] == argument), None)
        found.append(kind.pop(0) if kind else [])
    return found


def _ranked(ranking: Any, is_right: Any, is_chosen: Any) -> Certainty:
    """Of a list of alternatives with their probabilities, the most probable first."""
    rows = [(value, float(probability)) for value, probability in ranking]
    right = next((i for i, (value, _) in enumerate(rows) if is_right(value)), None)
    chosen = next((p for value, p in rows if is_chosen(value)), None)
    if right is None:
        return Certainty(chosen)
    return Certainty(chosen, rows[right][1], right + 1)


def _scope(value: Any) -> tuple[int, int] | None:
    return None if value is None else (int(value[0]), int(value[1]))
