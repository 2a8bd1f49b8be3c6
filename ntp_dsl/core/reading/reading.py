"""What was read of a program's lists from a demonstration, and how sure that is."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Set
from dataclasses import dataclass
from math import prod

from ntp_dsl.core.reading.candidates import Element
from ntp_dsl.semantics.observation import Argument, Record
from ntp_dsl.traces.schema import DemonstratedCall

MISSED = 0.1  # probability that a list is right which does not tell where something was put last


@dataclass(frozen=True)
class Doubt:
    """An element of a list that may be another, and how probable each is."""

    parameter: str
    number: int  # of the element, in its list
    frame: int  # the first of the phase in which it becomes true
    element: Element
    probability: float
    others: tuple[tuple[Element, float], ...]  # the most probable first
    answer: Element | None = None  # of whoever was asked

    def certainty(self, named: Set[str]) -> float:
        """Return how probable it is that an element is meant that names all of some objects and members."""
        others = (chance for element, chance in self.others if named <= {*values_in(element)})
        return self.probability + sum(others)

    @property
    def offered(self) -> frozenset[Element]:
        """Return all elements that may be meant."""
        return frozenset((self.element, *(element for element, _ in self.others)))


@dataclass(frozen=True)
class Measure:
    """An element with numbers, and how probably they are as near to those that are meant as it matters."""

    parameter: str
    number: int  # of the element, in its list
    element: Element
    probability: float

    def certainty(self, named: Set[str]) -> float:
        return self.probability


@dataclass(frozen=True)
class Stray:
    """An object that was put down last by an act that nothing explains, and the first frame after that."""

    item: str
    frame: int


@dataclass(frozen=True)
class Reading:
    """The arguments of a program as a demonstration shows them, and the calls that it shows."""

    arguments: tuple[Argument, ...]
    call: DemonstratedCall
    acts_explained: frozenset[int]  # by the hand's acts' numbers
    acts: int  # of the hand
    unexplained: tuple[int, ...] = ()  # of the other acts, the first frames after them
    unshown: tuple[str, ...] = ()  # fields of lists, as `goal.place`, of which the contract says nothing
    doubts: tuple[Doubt, ...] = ()  # elements that might as well be others
    measures: tuple[Measure, ...] = ()  # elements with numbers, where there is noise
    strays: tuple[Stray, ...] = ()
    in_passing: frozenset[int] = frozenset()  # acts whose released object is an argument of no running call

    @property
    def explained(self) -> int:
        """Return how many acts are explained."""
        return len(self.acts_explained)

    @property
    def probability(self) -> float:
        """Return how probable it is that the lists are right.

        Each element may be meant, or one that explains as much; its numbers may be near enough; and what
        was put somewhere last, for no reason that the lists give, may not matter. All these are taken for
        independent.
        """
        missed = max(len(self.strays), int(self.acts > 0 and not self.explained))
        return prod(each.probability for each in self._uncertain) * MISSED**missed

    def certainty(self, objects: Collection[str]) -> float:
        """Return how probable it is that the elements are right that name all of some objects and members."""
        if not objects:
            return 1.0
        named = {*objects}
        concerned = [each for each in self._uncertain if named <= {*values_in(each.element)}]
        return prod(each.certainty(named) for each in concerned)

    @property
    def _uncertain(self) -> Iterator[Doubt | Measure]:
        yield from (each for each in self.doubts if each.answer is None)
        yield from self.measures

    @property
    def is_whole(self) -> bool:
        """Return whether all acts are explained."""
        return self.explained == self.acts


def values_in(element: Element) -> list[str]:
    """Return the objects and members in an element."""
    values = [value for _, value in element.fields] if isinstance(element, Record) else [element]
    return [value for value in values if isinstance(value, str)]
