"""The worlds' own predicates with probabilities in place of truth values."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Protocol

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


class Seen(Protocol):
    """A moment as it is observed, and as it is graded."""

    @property
    def observation(self) -> Observation: ...

    @property
    def graded(self) -> Graded: ...


def _certain(name: str) -> Callable[..., float]:
    """Return a predicate of what an observation states, such as which objects there are."""
    return lambda seen, item: float(BUILT_IN[name](seen.observation, item))


def _touching(index: int) -> Callable[..., Any]:
    return lambda seen, item, below: seen.graded.contacts.get((item, below), NO_CONTACT)[index]


def _holding(seen: Seen, item: str) -> Any:
    return seen.graded.full if item == ANY else seen.graded.held.get(item, 0.0)


# The probability of each of the worlds' own predicates, of a `Seen` and the predicate's arguments.
GRADED: Mapping[str, Callable[..., Any]] = {
    "present": _certain("present"),
    "reachable": _certain("reachable"),
    "hollow": _certain("hollow"),
    "holding": _holding,
    "empty": lambda seen, hand: 1 - seen.graded.full,
    "on": _touching(0),
    "covers": _touching(1),
    "in": _touching(2),
    "clear": lambda seen, item: 1 - seen.graded.covered.get(item, 1.0),
    "above": lambda seen, hand, target: seen.graded.hovered.get(target, 0.0),
}
