"""Why facts and conditions do not hold, in words: which of their parts, and what readings say instead."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import replace
from itertools import chain

from ntp_dsl.common.text import enumerated
from ntp_dsl.language.diagnostics.diagnostics import NtpError
from ntp_dsl.language.syntax import nodes
from ntp_dsl.language.syntax.formatter import format_expression
from ntp_dsl.language.syntax.visitors import free_names
from ntp_dsl.semantics.facts import Bindings, Condition, Fact, Literal, bind
from ntp_dsl.semantics.observation import Argument
from ntp_dsl.semantics.parts import not_so
from ntp_dsl.semantics.predicates import ANY
from ntp_dsl.semantics.state import State

OPPOSITES = {"==": "!=", "!=": "==", "<": ">=", "<=": ">", ">": "<=", ">=": "<"}
MIRRORED = {"<": ">", "<=": ">=", ">": "<", ">=": "<="}  # with the sides exchanged
MOST = 3  # reasons that a sentence names


def why_not(fact: Fact, state: State) -> str:
    """Say that a fact does not hold, and of one with a body or a comparison what is in its way."""
    if isinstance(fact, Condition):
        return some_of(why_false(fact.expression, fact.scope, state)) or f"{fact} does not hold"
    reasons = _known(_of_literal(fact, state))
    return f"{_said(fact)}, as {some_of(reasons)}" if reasons and reasons != [_said(fact)] else _said(fact)


def why_false(expression: nodes.Expression, scope: Bindings, state: State) -> list[str]:
    """Return why an expression does not hold: what is to be otherwise, each said once."""
    return _known(_in_the_way(expression, scope, True, state))


def why_empty(generator: nodes.Generator, scope: Bindings, state: State) -> list[str]:
    """Return why no element of a loop meets its condition."""
    every = list(state.elements(replace(generator, condition=None), scope))
    if not every:
        return [f"there is nothing in '{generator.iterable.id}'"]
    assert generator.condition is not None, "without a condition, every element is one"
    told = (_in_the_way(generator.condition, each, True, state) for each in every)
    return _known(chain.from_iterable(told))


def _known(reasons: Iterator[str]) -> list[str]:
    """Return reasons, each once, as far as they can be told: evaluation may have stopped before the rest."""
    found: dict[str, None] = {}
    try:
        for each in reasons:
            found[each] = None
    except NtpError:
        pass
    return [*found]


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
            yield from _of_all([(each, scope) for each in values], positive, is_each, state)
        case nodes.Compare():
            yield _compared(expression, scope, positive, state)
        case nodes.Quantified(quantifier=quantifier, body=body, generators=generators, count=None) if (
            quantifier == "all"
        ) == positive:
            each_of = [(body, inner) for inner in state.scopes(generators, scope)]
            yield from _of_all(each_of, positive, True, state)
        case _:
            yield f"{_told(expression, scope)} {'does not hold' if positive else 'holds'}"


def _told(expression: nodes.Expression, scope: Bindings) -> str:
    """Return an expression as text, with what its names stand for."""
    named = [f"{name}={_shortly(scope[name])}" for name in sorted(free_names(expression)) if name in scope]
    return format_expression(expression) + f" with {', '.join(named)}" * bool(named)


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
    some: Iterable[tuple[nodes.Expression, Bindings]], positive: bool, is_each: bool, state: State
) -> Iterator[str]:
    """Yield what is in the way of several expressions; see `not_so`."""
    for expression, scope in not_so(some, positive, is_each, state):
        yield from _in_the_way(expression, scope, positive, state)


def _compared(expression: nodes.Compare, scope: Bindings, positive: bool, state: State) -> str:
    """Say what the sides of a comparison are, and what they were to be."""
    left, right = expression.left, expression.right
    values = [_shortly(state.value(side, scope)) for side in (left, right)]
    if all(isinstance(side, nodes.Name) for side in (left, right)):
        return f"both are {values[0]}" if values[0] == values[1] else f"{values[0]} is not {values[1]}"
    is_reading = [isinstance(side, nodes.Atom | nodes.Field) for side in (left, right)]
    if all(is_reading):
        return f"{_term(left, scope, state)} is {values[0]} and {_term(right, scope, state)} is {values[1]}"
    sign = expression.operator if positive else OPPOSITES[expression.operator]
    if is_reading == [False, True]:
        left, values, sign = right, values[::-1], MIRRORED.get(sign, sign)
    wanted = {"==": f", not {values[1]}", "!=": ""}.get(sign, f", which is not {sign} {values[1]}")
    return f"{_term(left, scope, state)} is {values[0]}{wanted}"


def _term(term: nodes.Expression, scope: Bindings, state: State) -> str:
    match term:
        case nodes.Atom(predicate=predicate, arguments=arguments):
            return _short(Literal(predicate, tuple(state.value(each, scope) for each in arguments)))
        case nodes.Name(id=name) if name in scope:
            return _shortly(scope[name])
        case nodes.Field():
            return f"{term.name} of {_shortly(scope[term.value.id])}"
    return format_expression(term)


def _said(literal: Literal) -> str:
    if literal.positive:
        return f"{_short(literal)} does not hold"
    return f"{_short(replace(literal, positive=True))} holds"


def _short(literal: Literal) -> str:
    return f"{literal.predicate}({', '.join(map(_shortly, literal.arguments))})"


def _shortly(value: Argument | bool) -> str:
    return f"{value:.4g}" if isinstance(value, float) else str(value)
