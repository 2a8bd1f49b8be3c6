"""Visitors of statements and expressions: what they call, apply and refer to."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from ntp_dsl.language.syntax import nodes
from ntp_dsl.language.syntax.nodes import Expression, Generator, Name, Statement


def innermost(statement: Statement) -> nodes.Call:
    """Return the call inside all loops and conditions."""
    while not isinstance(statement, nodes.Call):
        statement = statement.body
    return statement


def callees(program: nodes.ProgramDeclaration) -> tuple[str, ...]:
    """Return what a program may call, each once: in its body, or as declared for its expert in Python."""
    named = [innermost(statement).callee for statement in program.body]
    return tuple(dict.fromkeys([*named, *(each.id for each in program.calls)]))


def loops(statement: Statement) -> Iterator[Generator]:
    """Yield the generators around a statement's call, from the outside in."""
    while not isinstance(statement, nodes.Call):
        if isinstance(statement, nodes.For):
            yield statement.generator
        statement = statement.body


def guards(statement: Statement) -> Iterator[Expression]:
    """Yield the conditions of loops and `when` around a statement's call, from the outside in."""
    while not isinstance(statement, nodes.Call):
        if isinstance(statement, nodes.When):
            yield statement.condition
        elif statement.generator.condition is not None:
            yield statement.generator.condition
        statement = statement.body


def children(expression: Expression | Generator | None) -> Iterator[Expression | Generator]:
    """Yield the direct parts of an expression."""
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


def walk(expression: Expression | Generator | None) -> Iterator[Expression | Generator]:
    """Yield the expression and all its parts, from left to right."""
    if expression is not None:
        yield expression
        for part in children(expression):
            yield from walk(part)


def walk_statement(node: Statement | Expression) -> Iterator[Expression | Generator]:
    """Yield every expression of a statement, or of an expression."""
    match node:
        case nodes.Call(_, arguments):
            for argument in arguments:
                yield from walk(argument)
        case nodes.When(condition, body):
            yield from walk(condition)
            yield from walk_statement(body)
        case nodes.For(generator, body):
            yield from walk(generator)
            yield from walk_statement(body)
        case _:
            yield from walk(node)


def free_names(expression: Expression | Generator | None) -> set[str]:
    """Return the free names of an expression: all but the variables of its own loops."""
    match expression:
        case Name(id):
            return {id}
        case nodes.Quantified(_, body, generators):
            walk_statement = free_names(body).union(*map(free_names, generators))
            return walk_statement - {each.variable for each in generators}
    return set[str]().union(*map(free_names, children(expression)))


def predicates(expression: Expression | Generator | None) -> set[str]:
    """Return every predicate that an expression applies."""
    return {each.predicate for each in walk(expression) if isinstance(each, nodes.Atom)}


def atoms(condition: Expression | None) -> Iterator[nodes.Atom]:
    """Yield the atoms that certainly hold where the condition does."""
    if isinstance(condition, nodes.Atom):
        yield condition
    elif isinstance(condition, nodes.And):
        for value in condition.values:
            yield from atoms(value)


def conjuncts(condition: Expression) -> tuple[Expression, ...]:
    """Return the operands of `and`; the condition itself if it is none."""
    return condition.values if isinstance(condition, nodes.And) else (condition,)


def union(sets: Iterable[set[str]]) -> set[str]:
    return set[str]().union(*sets)
