"""What may hold in a state: literals, and conditions that are none."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from functools import cached_property

from ntp_dsl.language.syntax import nodes
from ntp_dsl.semantics.observation import Argument, without_lists
from ntp_dsl.semantics.predicates import ANY

Bindings = Mapping[str, Argument]


@dataclass(frozen=True)
class Literal:
    """A ground predicate, or its negation."""

    predicate: str
    arguments: tuple[Argument, ...]
    positive: bool = True

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
class Condition:
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

    def is_helped_by(self, literal: Literal) -> bool:
        """Return whether a literal, or what it implies of any object, helps to bring it about."""
        if literal in self._helped_by:
            return True
        return any(literal.provides(each) for each in self._vague if each.predicate == literal.predicate)

    @cached_property
    def _helped_by(self) -> frozenset[Literal]:
        return frozenset(self.helping())  # late: readings in it may be lacking where it holds anyway

    @cached_property
    def _vague(self) -> list[Literal]:
        return [each for each in self._helped_by if ANY in each.arguments]

    def provides(self, other: Fact) -> bool:
        return self == other

    @property
    def names(self) -> frozenset[str]:
        """Return the objects and members that it is about."""
        return _names(tuple(value for _, value in self.bindings))

    def __str__(self) -> str:
        return self.text


Fact = Literal | Condition


def bind(declared: nodes.PredicateDeclaration, arguments: tuple[Argument, ...]) -> Bindings:
    """Return the arguments of a predicate by the names of its parameters, for its body."""
    return dict(zip((parameter.name for parameter in declared.parameters), arguments, strict=True))


def _names(arguments: tuple[Argument, ...]) -> frozenset[str]:
    return frozenset(each for each in without_lists(arguments) if isinstance(each, str))
