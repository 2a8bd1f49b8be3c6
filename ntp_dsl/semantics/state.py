"""The state that contracts are evaluated in: an observation under a registry's predicates, with a cache."""

from __future__ import annotations

import operator
from collections.abc import Callable, Iterator, Mapping
from functools import partial
from itertools import product
from typing import Any, NamedTuple

from ntp_dsl.language.names.signatures import si
from ntp_dsl.language.registry import Registry
from ntp_dsl.language.syntax import nodes
from ntp_dsl.language.syntax.formatter import format_expression
from ntp_dsl.language.syntax.visitors import free_names
from ntp_dsl.semantics.facts import Bindings, Condition, Fact, Literal, bind
from ntp_dsl.semantics.observation import Argument, DeclaredFact, Observation, Record
from ntp_dsl.semantics.predicates import ANY, ANY_KNOWN, BUILT_IN, READINGS, trait

COMPARISONS: dict[str, Callable[[Any, Any], bool]] = {
    "==": operator.eq,
    "!=": operator.ne,
    "<": operator.lt,
    "<=": operator.le,
    ">": operator.gt,
    ">=": operator.ge,
}


ARITHMETIC: dict[str, Callable[[float, float], float]] = {
    "+": operator.add,
    "-": operator.sub,
    "*": operator.mul,
    "/": lambda a, b: a / b if b else float("inf"),
}


class Contract(NamedTuple):
    """The ground facts that a call requires, and those that it achieves."""

    requires: tuple[Fact, ...]
    achieves: tuple[Fact, ...]


class State:
    """One moment, as the language sees it. Answers are cached."""

    def __init__(
        self,
        registry: Registry,
        observation: Observation,
        built_in: Mapping[str, Callable[..., bool]] = BUILT_IN,
    ) -> None:
        self.registry = registry
        self.observation = observation
        self._built_in = built_in
        self.memo: dict[Any, Any] = {}  # what follows from this moment alone, for who computes it
        self._known: dict[tuple[str, tuple[Argument, ...]], Any] = {}
        self._domains: dict[str, tuple[str, ...]] = {}
        self._contracts: dict[tuple[str, tuple[Argument, ...]], Contract] = {}

    def holds(self, fact: Fact) -> bool:
        if isinstance(fact, Condition):
            return self.true(fact.expression, fact.scope)
        return bool(self.reading(fact.predicate, fact.arguments)) == fact.positive

    def reading(self, predicate: str, arguments: tuple[Argument, ...]) -> Any:
        """Return a predicate's value for its arguments: a truth value, or a reading's number or member."""
        key = (predicate, arguments)
        known = self._known.get(key)
        if known is None:
            known = self._known[key] = self._ask(*key)
        return known

    def forced(self, predicate: str, arguments: tuple[Argument, ...]) -> bool | None:
        """Return what somebody forces on a fact; None where nobody does."""
        if not self.observation.forced:
            return None
        return self.observation.forced.get(DeclaredFact(predicate, tuple(map(str, arguments))))

    def objects(self, type_name: str) -> list[str]:
        """Return the names of the scene's objects of a type, in the observation's order."""
        is_a = self.registry.is_a
        return [t.name for t in self.observation.objects if is_a(t.type, type_name)]

    def domain(self, name: str) -> tuple[str, ...]:
        """Return what a loop goes through: an enumeration's members, or the scene's objects of a type."""
        known = self._domains.get(name)
        if known is None:
            enums = self.registry.enums
            known = self._domains[name] = tuple(enums[name] if name in enums else self.objects(name))
        return known

    def values(self, type_name: str) -> list[str]:
        """Return the members of an enumeration, or the objects and constants of a type."""
        if type_name in self.registry.enums:
            return list(self.registry.enums[type_name])
        constants = [n for n, kind in self.registry.constants.items() if self.registry.is_a(kind, type_name)]
        return list(dict.fromkeys([*self.objects(type_name), *constants]))

    def ways(
        self, declared: nodes.PredicateDeclaration, arguments: tuple[Argument, ...]
    ) -> Iterator[tuple[Argument, ...]] | None:
        """Return every way to put something in the place of each `any`; None where there is none to replace.

        Of some predicates the world itself says whether they hold of anything.
        """
        is_known = declared.by is None and declared.name in ANY_KNOWN
        if ANY not in arguments or declared.result is not None or is_known:
            return None
        pairs = zip(declared.parameters, arguments, strict=True)
        return product(*(self.values(p.type.name) if each == ANY else (each,) for p, each in pairs))

    def true(self, expression: nodes.Expression | None, scope: Bindings) -> bool:
        """Return whether an expression holds; None always does."""
        match expression:
            case None:
                return True
            case nodes.Atom(predicate=predicate, arguments=arguments):
                return self.holds(Literal(predicate, self._values(arguments, scope)))
            case nodes.Not(value=value):
                return not self.true(value, scope)
            case nodes.And(values=values):
                return all(self.true(value, scope) for value in values)
            case nodes.Or(values=values):
                return any(self.true(value, scope) for value in values)
            case nodes.Compare(operator=sign, left=left, right=right):
                return COMPARISONS[sign](self.value(left, scope), self.value(right, scope))
            case nodes.Quantified(quantifier=quantifier, body=body, generators=generators):
                inner = (self.true(body, each) for each in self.scopes(generators, scope))
                if expression.count is not None:
                    count = sum(inner)
                    return count == expression.count if quantifier == "exactly" else count >= expression.count
                return (all if quantifier == "all" else any)(inner)
        raise TypeError(f"{expression} is not a truth value")

    def contract(self, name: str, arguments: tuple[Argument, ...]) -> Contract:
        """Return the ground facts of the contract of a program or an api."""
        key = (name, arguments)
        known = self._contracts.get(key)
        if known is None:
            declared = self.registry[name]
            scope = declared.bind(arguments)
            requires, achieves = (
                self.literals(part, scope) for part in (declared.requires, declared.achieves)
            )
            known = self._contracts[key] = Contract(tuple(requires), tuple(achieves))
        return known

    def literals(
        self, expression: nodes.Expression | None, scope: Bindings, positive: bool = True
    ) -> list[Fact]:
        """Return the ground facts of a contract: conjunctions and `all` expanded, negation moved inwards."""
        match expression, positive:
            case None, _:
                return []
            case nodes.Atom(predicate=predicate, arguments=arguments), _:
                return [Literal(predicate, self._values(arguments, scope), positive)]
            case nodes.Not(value=value), _:
                return self.literals(value, scope, not positive)
            case (nodes.And(values=values), True) | (nodes.Or(values=values), False):
                return [fact for value in values for fact in self.literals(value, scope, positive)]
            case nodes.Quantified(quantifier, body, generators, None), _:
                if (quantifier == "all") == positive:
                    inner = self.scopes(generators, scope)
                    return [fact for s in inner for fact in self.literals(body, s, positive)]
        assert expression is not None
        return [self._condition(expression if positive else nodes.Not(expression), scope)]

    def _condition(self, expression: nodes.Expression, scope: Bindings) -> Condition:
        named = {name: scope[name] for name in sorted(free_names(expression)) if name in scope}
        given = ", ".join(f"{name}={value}" for name, value in named.items() if not isinstance(value, tuple))
        text = format_expression(expression)
        told = f"{text} with {given}" if given else text
        helping = partial(self.helping, expression, scope)
        return Condition(told, expression, scope, tuple(named.items()), helping)

    def helping(
        self, expression: nodes.Expression | None, scope: Bindings, positive: bool = True
    ) -> Iterator[Literal]:
        """Yield the literals that help to make an expression true, or false.

        Where an exact number has to hold, more of them help unless there are too many: then fewer do.
        """
        match expression:
            case nodes.Atom(predicate=predicate, arguments=arguments):
                yield Literal(predicate, self._values(arguments, scope), positive)
            case nodes.Not(value=value):
                yield from self.helping(value, scope, not positive)
            case nodes.And(values=values) | nodes.Or(values=values):
                for value in values:
                    yield from self.helping(value, scope, positive)
            case nodes.Quantified(quantifier=quantifier, body=body, generators=generators):
                inner = [*self.scopes(generators, scope)]
                if quantifier == "exactly":
                    positive = sum(self.true(body, each) for each in inner) <= (expression.count or 0)
                for each in inner:
                    yield from self.helping(body, each, positive)

    def elements(self, generator: nodes.Generator, scope: Bindings) -> Iterator[Bindings]:
        """Yield a scope for each element of a list, object of a type or member that meets the condition."""
        iterable = generator.iterable.id
        source = scope[iterable] if iterable in scope else self.domain(iterable)
        assert isinstance(source, tuple)
        for element in source:
            inner: Bindings = {**scope, generator.variable: element}
            if self.true(generator.condition, inner):
                yield inner

    def value(self, term: nodes.Expression, scope: Bindings) -> Argument:
        match term:
            case nodes.Name(id=name):
                return scope.get(name, name)
            case nodes.Atom(predicate=predicate, arguments=arguments):
                reading: Argument = self.reading(predicate, self._values(arguments, scope))
                return reading
            case nodes.Field(value=owner, name=field):
                record = scope[owner.id]
                assert isinstance(record, Record)
                return record[field]
            case nodes.Wildcard():
                return ANY
            case nodes.Number():
                number = si(term)
                assert number is not None
                return number
            case nodes.Arithmetic(operator=sign, left=left, right=right):
                return ARITHMETIC[sign](self._number(left, scope), self._number(right, scope))
        raise TypeError(f"{term} is not a term")

    def _number(self, term: nodes.Expression, scope: Bindings) -> float:
        value = self.value(term, scope)
        assert isinstance(value, int | float), "the checker lets numbers alone be calculated with"
        return float(value)

    def _values(self, terms: tuple[nodes.Expression, ...], scope: Bindings) -> tuple[Argument, ...]:
        return tuple([self.value(term, scope) for term in terms])

    def scopes(self, generators: tuple[nodes.Generator, ...], scope: Bindings) -> Iterator[Bindings]:
        """Yield a scope for each way to choose an element for every generator."""
        if not generators:
            yield scope
            return
        for inner in self.elements(generators[0], scope):
            yield from self.scopes(generators[1:], inner)

    def _ask(self, predicate: str, arguments: tuple[Argument, ...]) -> Any:
        if (forced := self.forced(predicate, arguments)) is not None:
            return forced
        declared = self.registry.predicates[predicate]
        ways = self.ways(declared, arguments)
        if ways is not None:
            return any(self.reading(predicate, way) for way in ways)
        if declared.body is not None:
            return self.true(declared.body, bind(declared, arguments))
        if declared.is_state:
            return DeclaredFact(predicate, tuple(map(str, arguments))) in self.observation.facts
        return self._provided(declared, arguments)

    def _provided(self, declared: nodes.PredicateDeclaration, arguments: tuple[Argument, ...]) -> Any:
        """Return what the world's own predicate, a function in Python, or the reading of a trait says."""
        name = declared.provider
        if name == nodes.PYTHON:
            function: Callable[..., Any] = self.registry.python.get("predicate", declared.name)
        elif declared.result is None:
            function = self._built_in[name]
        else:
            function = READINGS[name] if name in READINGS else trait(declared.name)
        return function(self.observation, *arguments)
