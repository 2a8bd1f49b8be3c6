"""Walks over statements and conditions: what they call, apply and mention."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from ntp_dsl.language.syntax import nodes
from ntp_dsl.language.syntax.nodes import Expression, Generator, Name, Statement


def innermost(statement: Statement) -> nodes.Call:
    """The call inside all loops and conditions."""
    while not isinstance(statement, nodes.Call):
        statement = statement.body
    return statement


def callees(program: nodes.ProgramDeclaration) -> tuple[str, ...]:
    """What a program may call, each once: by its body, or as it says of its expert in Python."""
    named = [innermost(statement).callee for statement in program.body]
    return tuple(dict.fromkeys([*named, *(each.id for each in program.calls)]))


def loops(statement: Statement) -> Iterator[Generator]:
    """The generators around a statement's call, from the outside in."""
    while not isinstance(statement, nodes.Call):
        if isinstance(statement, nodes.For):
            yield statement.generator
        statement = statement.body


def guards(statement: Statement) -> Iterator[Expression]:
    """What loops' filters and `when` say about the call inside, from the outside in."""
    while not isinstance(statement, nodes.Call):
        if isinstance(statement, nodes.When):
            yield statement.condition
        elif statement.generator.condition is not None:
            yield statement.generator.condition
        statement = statement.body


def parts(expression: Expression | Generator | None) -> Iterator[Expression | Generator]:
    """The expressions of which one is made, one step down."""
    match expression:
        case nodes.Field(value, _) | nodes.Not(value):
            yield value
        case nodes.Atom(_, values) | nodes.And(values) | nodes.Or(values):
            yield from values
        case nodes.Arithmetic(_, left, right) | nodes.Compare(_, left, right):
            yield from (left, right)
        case nodes.Quantified(_, body, generators):
            yield body
            yield from generators
        case Generator(_, iterable, condition):
            yield iterable
            if condition is not None:
                yield condition


def everything(expression: Expression | Generator | None) -> Iterator[Expression | Generator]:
    """The expression and all that it is made of, from left to right."""
    if expression is not None:
        yield expression
        for part in parts(expression):
            yield from everything(part)


def inside(node: Statement | Expression) -> Iterator[Expression | Generator]:
    """Every expression of a statement, or of an expression."""
    match node:
        case nodes.Call(_, arguments):
            for argument in arguments:
                yield from everything(argument)
        case nodes.When(condition, body):
            yield from everything(condition)
            yield from inside(body)
        case nodes.For(generator, body):
            yield from everything(generator)
            yield from inside(body)
        case _:
            yield from everything(node)


def mentions(expression: Expression | Generator | None) -> set[str]:
    """Every name that occurs in an expression and is not its own loop's variable."""
    match expression:
        case Name(id):
            return {id}
        case nodes.Quantified(_, body, generators):
            inside = mentions(body).union(*map(mentions, generators))
            return inside - {each.variable for each in generators}
    return set[str]().union(*map(mentions, parts(expression)))


def predicates(expression: Expression | Generator | None) -> set[str]:
    """Every predicate that an expression applies."""
    return {each.predicate for each in everything(expression) if isinstance(each, nodes.Atom)}


def atoms(condition: Expression | None) -> Iterator[nodes.Atom]:
    """The predicates that surely hold where the condition does."""
    if isinstance(condition, nodes.Atom):
        yield condition
    elif isinstance(condition, nodes.And):
        for value in condition.values:
            yield from atoms(value)


def conjuncts(condition: Expression) -> tuple[Expression, ...]:
    """What is joined by `and`."""
    return condition.values if isinstance(condition, nodes.And) else (condition,)


def union(sets: Iterable[set[str]]) -> set[str]:
    return set[str]().union(*sets)
