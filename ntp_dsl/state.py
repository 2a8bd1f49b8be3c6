"""The state that contracts are read in: an observation under a registry's predicates, each asked once."""

from __future__ import annotations

import operator
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from ntp_dsl.language import syntax
from ntp_dsl.predicates import ANY, BUILT_IN
from ntp_dsl.registry import Registry
from ntp_dsl.world import Argument, Observation, Record

Bindings = Mapping[str, Argument]

COMPARISONS: dict[str, Callable[[Any, Any], bool]] = {
    "==": operator.eq,
    "!=": operator.ne,
    "<": operator.lt,
    "<=": operator.le,
    ">": operator.gt,
    ">=": operator.ge,
}


@dataclass(frozen=True)
class Literal:
    """A ground predicate, or its negation."""

    predicate: str
    arguments: tuple[Argument, ...]
    positive: bool = True

    def provides(self, other: Literal) -> bool:
        """Whether where this holds the other does: `holding(x)` provides `holding(any)`."""
        return (
            self.predicate == other.predicate
            and self.positive == other.positive
            and all(b in (a, ANY) for a, b in zip(self.arguments, other.arguments, strict=True))
        )

    def __str__(self) -> str:
        text = f"{self.predicate}({', '.join(map(str, self.arguments))})"
        return text if self.positive else f"not {text}"


class State:
    """One moment, as the language sees it. Answers are kept, so that asking again costs nothing."""

    def __init__(
        self,
        registry: Registry,
        observation: Observation,
        built_in: Mapping[str, Callable[..., bool]] = BUILT_IN,
    ) -> None:
        self.registry = registry
        self.observation = observation
        self._built_in = built_in
        self._known: dict[tuple[str, tuple[Argument, ...]], bool] = {}

    def holds(self, literal: Literal) -> bool:
        key = (literal.predicate, literal.arguments)
        if key not in self._known:
            self._known[key] = self._ask(*key)
        return self._known[key] == literal.positive

    def things(self, type_name: str) -> list[str]:
        """Names of the scene's things of a type, in the observation's order."""
        is_a = self.registry.is_a
        return [t.name for t in self.observation.things if is_a(t.type, type_name)]

    def true(self, expression: syntax.Expression | None, scope: Bindings) -> bool:
        """Whether an expression holds; no expression holds always."""
        match expression:
            case None:
                return True
            case syntax.Atom(predicate=predicate, arguments=arguments):
                return self.holds(Literal(predicate, self._values(arguments, scope)))
            case syntax.Not(value=value):
                return not self.true(value, scope)
            case syntax.And(values=values):
                return all(self.true(value, scope) for value in values)
            case syntax.Or(values=values):
                return any(self.true(value, scope) for value in values)
            case syntax.Compare(operator=sign, left=left, right=right):
                return COMPARISONS[sign](self.value(left, scope), self.value(right, scope))
            case syntax.Quantified(quantifier=quantifier, body=body, generators=generators):
                inner = self._scopes(generators, scope)
                return (all if quantifier == "all" else any)(self.true(body, s) for s in inner)
        raise TypeError(f"{expression} is not a truth value")

    def literals(self, expression: syntax.Expression | None, scope: Bindings) -> list[Literal]:
        """The ground literals of a contract: conjunctions and `all` are spelt out."""
        match expression:
            case None:
                return []
            case syntax.Atom(predicate=predicate, arguments=arguments):
                return [Literal(predicate, self._values(arguments, scope))]
            case syntax.Not(value=syntax.Atom(predicate=predicate, arguments=arguments)):
                return [Literal(predicate, self._values(arguments, scope), positive=False)]
            case syntax.And(values=values):
                return [literal for value in values for literal in self.literals(value, scope)]
            case syntax.Quantified(quantifier="all", body=body, generators=generators):
                inner = self._scopes(generators, scope)
                return [literal for s in inner for literal in self.literals(body, s)]
        raise TypeError(f"a contract is made of literals, 'and' and 'all'; found {expression}")

    def elements(self, generator: syntax.Generator, scope: Bindings) -> Iterator[Bindings]:
        """One scope per element of a list, or per thing of a type, that meets the condition."""
        iterable = generator.iterable.id
        source = scope[iterable] if iterable in scope else tuple(self.things(iterable))
        assert isinstance(source, tuple)
        for element in source:
            inner: Bindings = {**scope, generator.variable: element}
            if self.true(generator.condition, inner):
                yield inner

    def value(self, term: syntax.Expression, scope: Bindings) -> Argument:
        match term:
            case syntax.Name(id=name):
                return scope.get(name, name)
            case syntax.Wildcard():
                return ANY
            case syntax.Number(value=number):
                return number
            case syntax.Field(value=syntax.Name(id=name), name=field):
                record = scope[name]
                assert isinstance(record, Record)
                return record[field]
        raise TypeError(f"{term} is not a term")

    def _values(
        self, terms: tuple[syntax.Expression, ...], scope: Bindings
    ) -> tuple[Argument, ...]:
        return tuple(self.value(term, scope) for term in terms)

    def _scopes(
        self, generators: tuple[syntax.Generator, ...], scope: Bindings
    ) -> Iterator[Bindings]:
        if not generators:
            yield scope
            return
        for inner in self.elements(generators[0], scope):
            yield from self._scopes(generators[1:], inner)

    def _ask(self, predicate: str, arguments: tuple[Argument, ...]) -> bool:
        declaration = self.registry.predicates[predicate]
        if declaration.body is None:
            return self._built_in[predicate](self.observation, *arguments)
        names = (parameter.name for parameter in declaration.parameters)
        return self.true(declaration.body, dict(zip(names, arguments, strict=True)))
