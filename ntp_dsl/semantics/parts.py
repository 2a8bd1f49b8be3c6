"""What goes towards a fact that is said in other words: parts of predicates with bodies, of counts, of `or`.

`on(cup, saucer)` goes towards `served(cup)` where the body of `served` says so; `stacked(cup, saucer)` does
where both bodies say it. What holds already is a part of nothing.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Collection, Iterable, Iterator, Mapping
from functools import cached_property

from ntp_dsl.language.diagnostics.diagnostics import NtpError
from ntp_dsl.language.syntax import nodes
from ntp_dsl.semantics.facts import Bindings, Condition, Fact, Literal, bind
from ntp_dsl.semantics.predicates import ANY
from ntp_dsl.semantics.state import State


class Wanted:
    """Facts by their parts; those that hold are left out."""

    def __init__(self, facts: Iterable[Fact], state: State) -> None:
        self._facts, self._state = tuple(facts), state
        self._any_compound = any(is_compound(fact, state) for fact in self._facts)

    @cached_property
    def _by_part(self) -> Mapping[Literal, list[Fact]]:
        found: defaultdict[Literal, list[Fact]] = defaultdict(list)
        for fact in self._facts:
            for part in parts(fact, self._state):
                found[part].append(fact)
        return found

    @cached_property
    def _vague(self) -> list[Literal]:
        return [part for part in self._by_part if ANY in part.arguments]

    def helped_by(self, provided: Collection[Fact]) -> set[Fact]:
        """Return the facts towards which others go; of two literals without bodies, `provides` tells it."""
        if not self._any_compound and not any(is_compound(each, self._state) for each in provided):
            return set()  # as in most cases
        return {
            fact
            for each in provided
            for part in parts(each, self._state)
            for fact in self._with(part)
            if is_compound(each, self._state) or is_compound(fact, self._state)
        }

    def _with(self, part: Literal) -> Iterator[Fact]:
        """Yield the facts that have a part, or one that it implies."""
        yield from self._by_part.get(part, ())
        for other in self._by_part if ANY in part.arguments else self._vague:
            if other != part and part.provides(other):
                yield from self._by_part[other]


def is_compound(fact: Fact, state: State) -> bool:
    """Return whether a fact has parts other than itself."""
    return isinstance(fact, Condition) or fact.predicate in state.registry.composed


def parts(fact: Fact, state: State) -> frozenset[Literal]:
    """Return the literals that do not hold and go towards a fact that does not hold."""
    known: dict[Fact, frozenset[Literal]] = state.memo.setdefault(parts, {})
    if fact not in known:
        known[fact] = frozenset() if state.holds(fact) else frozenset(_parts_of_fact(fact, state))
    return known[fact]


def _parts_of_fact(fact: Fact, state: State) -> Iterator[Literal]:
    if isinstance(fact, Condition):
        yield from _parts(fact.expression, fact.scope, True, state)
        return
    yield fact
    if fact.predicate in state.registry.composed and ANY not in fact.arguments:
        declared = state.registry.predicates[fact.predicate]
        scope = bind(declared, fact.arguments)
        yield from _parts(declared.body, scope, fact.positive, state)


def _parts(
    expression: nodes.Expression | None, scope: Bindings, positive: bool, state: State
) -> Iterator[Literal]:
    """Yield the literals that go towards the truth of an expression that is false, or the other way round."""
    match expression:
        case nodes.Atom(predicate=predicate, arguments=arguments):
            given = tuple(state.value(term, scope) for term in arguments)
            yield from parts(Literal(predicate, given, positive), state)
        case nodes.Not(value=value):
            yield from _parts(value, scope, not positive, state)
        case nodes.And(values=values) | nodes.Or(values=values):
            is_each = isinstance(expression, nodes.And) == positive  # all of them are needed, or else one
            yield from _of_all([(each, scope) for each in values], positive, is_each, state)
        case nodes.Quantified(quantifier=quantifier, body=body, generators=generators):
            inner = [(body, each) for each in state.scopes(generators, scope)]
            if expression.count is not None:
                count = sum(state.true(*each) for each in inner)
                needs_more = count < expression.count if positive else quantifier == "exactly"
                yield from _of_all(inner, needs_more, False, state)
            else:
                yield from _of_all(inner, positive, (quantifier == "all") == positive, state)


def _of_all(
    some: Iterable[tuple[nodes.Expression, Bindings]], positive: bool, is_each: bool, state: State
) -> Iterator[Literal]:
    """Yield the parts of several expressions; see `not_so`."""
    for expression, scope in not_so(some, positive, is_each, state):
        yield from _parts(expression, scope, positive, state)


def not_so(
    some: Iterable[tuple[nodes.Expression, Bindings]], positive: bool, is_each: bool, state: State
) -> Iterator[tuple[nodes.Expression, Bindings]]:
    """Yield those of several expressions that are not true, or not false.

    Args:
        is_each: all of them are needed. One that is written after one that is lacking may have no meaning
            yet, as in `holding(b) and faces(b, side_of(b))`: it is asked for nothing.
    """
    is_lacking = False
    for expression, scope in some:
        try:
            is_so = state.true(expression, scope) == positive
        except NtpError:
            if not (is_each and is_lacking):
                raise
            continue
        if not is_so:
            is_lacking = True
            yield expression, scope
