"""What may hold in a state: literals, and conditions that are none; and what helps to bring them about."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import ClassVar

from ntp_dsl.language.syntax import nodes
from ntp_dsl.semantics.observation import Argument, without_lists
from ntp_dsl.semantics.predicates import ANY

Bindings = Mapping[str, Argument]


class _Helped:
    """What is brought about by literals, one after the other."""

    helping: Callable[[], Iterable[Literal]]

    def is_helped_by(self, literal: Literal) -> bool:
        """Return whether a literal, or what it implies of any object, helps to bring it about."""
        if literal in self.helped_by:
            return True
        return any(literal.provides(each) for each in self._vague if each.predicate == literal.predicate)

    @cached_property
    def helped_by(self) -> frozenset[Literal]:
        """The literals that help, and those that help composed ones among them."""
        found, waiting = set[Literal](), [*self.helping()]  # late: readings may be lacking where it holds
        while waiting:
            literal = waiting.pop()
            if literal not in found:
                found.add(literal)
                waiting += literal.helping()
        return frozenset(found)

    @cached_property
    def _vague(self) -> list[Literal]:
        return [each for each in self.helped_by if ANY in each.arguments]


@dataclass(frozen=True)
class Literal(_Helped):
    """A ground predicate, or its negation.

    Args:
        helping: returns the literals of which a composed one consists; none of others.
    """

    predicate: str
    arguments: tuple[Argument, ...]
    positive: bool = True
    helping: Callable[[], Iterable[Literal]] = field(default=tuple, compare=False, repr=False)

    @property
    def is_compound(self) -> bool:
        return self.helping is not tuple

    def provides(self, other: Fact) -> bool:
        """Return whether this fact implies the other.

        `holding(x)` provides `holding(any)`, and `not holding(any)` provides `not holding(x)`. For a
        condition, it need only be one of the literals that help to bring it about.
        """
        if isinstance(other, Condition):
            return other.is_helped_by(self)
        if self.predicate != other.predicate:
            return False
        some, more = (self, other) if self.positive else (other, self)
        pairs = zip(some.arguments, more.arguments, strict=True)
        return self.positive == other.positive and all(b in (a, ANY) for a, b in pairs)

    @property
    def names(self) -> frozenset[str]:
        """Return the objects and members that it is about."""
        return _names(self.arguments)

    def __str__(self) -> str:
        given = [f"{each:g}" if isinstance(each, float) else str(each) for each in self.arguments]
        text = f"{self.predicate}({', '.join(given)})"
        return text if self.positive else f"not {text}"


@dataclass(frozen=True)
class Condition(_Helped):
    """A part of a contract that is not a literal: a comparison, a count or a disjunction.

    Args:
        bindings: of the names in it.
        helping: returns the literals of which more have to hold, or one of which has to, for it to hold.
    """

    text: str
    expression: nodes.Expression = field(compare=False, repr=False)
    scope: Bindings = field(compare=False, repr=False)
    bindings: tuple[tuple[str, Argument], ...] = ()
    helping: Callable[[], Iterable[Literal]] = field(default=tuple, compare=False, repr=False)
    is_compound: ClassVar[bool] = True

    def provides(self, other: Fact) -> bool:
        """Return whether this implies the other, or is helped by what helps the other, if a condition is."""
        return self == other or (
            isinstance(other, Condition) and any(map(other.is_helped_by, self.helped_by))
        )

    @property
    def names(self) -> frozenset[str]:
        """Return the objects and members that it is about."""
        return _names(tuple(value for _, value in self.bindings))

    def __str__(self) -> str:
        return self.text


Fact = Literal | Condition


def has_part(provided: Iterable[Fact], wanted: Fact) -> bool:
    """Return whether one of some facts, or a part of one, is a part of a fact; equal ones are left out.

    It tells what of a predicate with a body goes towards what is said in other words.
    """
    return any(_shares(each, wanted) for each in provided)


def _shares(provided: Fact, wanted: Fact) -> bool:
    parts = provided.helped_by if provided.is_compound else frozenset(_literals(provided))
    if not wanted.is_compound:
        return provided.is_compound and wanted in parts
    return any(map(wanted.is_helped_by, parts))


def _literals(fact: Fact) -> Iterator[Literal]:
    if isinstance(fact, Literal):
        yield fact


def _names(arguments: tuple[Argument, ...]) -> frozenset[str]:
    return frozenset(each for each in without_lists(arguments) if isinstance(each, str))
