"""The worlds' own predicates with probabilities in place of truth values."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from ntp_dsl.semantics.observation import Observation
from ntp_dsl.semantics.predicates import ANY, BUILT_IN

NO_CONTACT = (0.0, 0.0, 0.0)


@dataclass(frozen=True)
class Graded:
    """The probabilities of one moment: numbers, or tensors. What is not listed is not the case."""

    contacts: Mapping[tuple[str, str], tuple[Any, Any, Any]]  # an object on, covering, in another
    held: Mapping[str, Any]
    hovered: Mapping[str, Any]  # what the hand, or what it holds, is over
    covered: Mapping[str, Any]  # by anything
    full: Any  # the hand holds something


def graded_predicates(seen: Observation, graded: Callable[[], Graded]) -> Mapping[str, Callable[..., Any]]:
    """Return, by name, the probability of each of the worlds' own predicates of its arguments.

    What an observation states, such as which objects there are, is certain.

    Args:
        graded: asked only where a predicate needs it.
    """

    def certain(name: str) -> Callable[..., float]:
        return lambda item: float(BUILT_IN[name](seen, item))

    def touching(index: int) -> Callable[..., Any]:
        return lambda item, below: graded().contacts.get((item, below), NO_CONTACT)[index]

    return {
        "present": certain("present"),
        "reachable": certain("reachable"),
        "hollow": certain("hollow"),
        "holding": lambda item: graded().full if item == ANY else graded().held.get(item, 0.0),
        "empty": lambda hand: 1 - graded().full,
        "on": touching(0),
        "covers": touching(1),
        "in": touching(2),
        "clear": lambda item: 1 - graded().covered.get(item, 1.0),
        "above": lambda hand, target: graded().hovered.get(target, 0.0),
    }
