"""Why facts and conditions do not hold, in words: which of their parts, and what readings say instead."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import replace
from itertools import chain

from ntp_dsl.common.text import enumerated
from ntp_dsl.language.diagnostics.diagnostics import NtpError
from ntp_dsl.language.syntax import nodes
from ntp_dsl.language.syntax.formatter import format_expression
from ntp_dsl.semantics.facts import Bindings, Condition, Fact, Literal, bind
from ntp_dsl.semantics.observation import Argument
from ntp_dsl.semantics.predicates import ANY
from ntp_dsl.semantics.state import State

MOST = 3  # reasons that a sentence names


def why_not(fact: Fact, state: State) -> str:
    """Say that a fact does not hold, and of one with a body or a comparison what is in its way."""
    if isinstance(fact, Condition):
        return some_of(why_false(fact.expression, fact.scope, state)) or f"{fact} does not hold"
    reasons = [*dict.fromkeys(_of_literal(fact, state))]
    return f"{_said(fact)}, as {some_of(reasons)}" if reasons and reasons != [_said(fact)] else _said(fact)


def why_false(expression: nodes.Expression, scope: Bindings, state: State) -> list[str]:
    """Return why an expression does not hold: what is to be otherwise, each said once."""
    return list(dict.fromkeys(_in_the_way(expression, scope, True, state)))


def why_empty(generator: nodes.Generator, scope: Bindings, state: State) -> list[str]:
    """Return why no element of a loop meets its condition."""
    every = list(state.elements(replace(generator, condition=None), scope))
    if not every:
        return [f"there is nothing in '{generator.iterable.id}'"]
    assert generator.condition is not None, "without a condition, every element is one"
    told = (_in_the_way(generator.condition, each, True, state) for each in every)
    return list(dict.fromkeys(chain.from_iterable(told)))


def some_of(reasons: Iterable[str]) -> str:
    """Return the first reasons as an enumeration, and how many there are besides."""
    told = list(reasons)
    more = [f"{len(told) - MOST} more"] if len(told) > MOST else []
    return enumerated([*told[:MOST], *more])


def _in_the_way(expression: nodes.Expression, scope: Bindings, positive: bool, state: State) -> Iterator[str]:
    """Yield why an expression is not true, or not false."""
    if state.true(expression, scope) == positive:
        return
    match expression:
        case nodes.Atom(predicate=predicate, arguments=arguments):
            given = tuple(state.value(term, scope) for term in arguments)
            yield from _of_literal(Literal(predicate, given, positive), state)
        case nodes.Not(value=value):
            yield from _in_the_way(value, scope, not positive, state)
        case nodes.And(values=values) | nodes.Or(values=values):
            is_each = isinstance(expression, nodes.And) == positive
            yield from _of_all(values, scope, positive, is_each, state)
        case nodes.Compare():
            yield _compared(expression, scope, positive, state)
        case nodes.Quantified(quantifier=quantifier, body=body, generators=generators, count=None):
            if (quantifier == "all") == positive:
                inner = state.scopes(generators, scope)
                yield from chain.from_iterable(_in_the_way(body, each, positive, state) for each in inner)
            else:
                yield f"{format_expression(body)} {'holds of nothing' if positive else 'holds of all'}"
        case _:
            yield f"{format_expression(expression)} {'does not hold' if positive else 'holds'}"


def _of_literal(literal: Literal, state: State) -> Iterator[str]:
    """Yield why a literal does not hold: what is in the way of its body, where it has one."""
    if literal.predicate in state.registry.composed and ANY not in literal.arguments:
        declared = state.registry.predicates[literal.predicate]
        assert declared.body is not None
        scope = bind(declared, literal.arguments)
        yield from _in_the_way(declared.body, scope, literal.positive, state)
    else:
        yield _said(literal)


def _of_all(
    values: Iterable[nodes.Expression], scope: Bindings, positive: bool, is_each: bool, state: State
) -> Iterator[str]:
    """Yield what is in the way of several expressions.

    Args:
        is_each: all of them are needed. What is written after one that is lacking may have no meaning yet.
    """
    is_lacking = False
    for each in values:
        try:
            found = [*_in_the_way(each, scope, positive, state)]
        except NtpError:
            if not (is_each and is_lacking):
                raise
            continue
        is_lacking |= bool(found)
        yield from found


def _compared(expression: nodes.Compare, scope: Bindings, positive: bool, state: State) -> str:
    """Say what the sides of a comparison are."""
    left, right = expression.left, expression.right
    is_reading = [isinstance(side, nodes.Atom | nodes.Field) for side in (left, right)]
    if is_reading == [False, True]:
        left, right = right, left
    found = f"{_term(left, scope, state)} is {_shortly(state.value(left, scope))}"
    if all(is_reading):
        return f"{found} and {_term(right, scope, state)} is {_shortly(state.value(right, scope))}"
    if expression.operator == "==" and positive:
        return f"{found}, not {_shortly(state.value(right, scope))}"
    return found


def _term(term: nodes.Expression, scope: Bindings, state: State) -> str:
    match term:
        case nodes.Atom(predicate=predicate, arguments=arguments):
            return str(Literal(predicate, tuple(state.value(each, scope) for each in arguments)))
        case nodes.Name(id=name) if name in scope:
            return _shortly(scope[name])
    return format_expression(term)


def _said(literal: Literal) -> str:
    if literal.positive:
        return f"{_short(literal)} does not hold"
    return f"{_short(replace(literal, positive=True))} holds"


def _short(literal: Literal) -> str:
    return f"{literal.predicate}({', '.join(map(_shortly, literal.arguments))})"


def _shortly(value: Argument | bool) -> str:
    return f"{value:.4g}" if isinstance(value, float) else str(value)
