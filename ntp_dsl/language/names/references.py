"""References: every name in a declaration that another one may declare."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from ntp_dsl.language.names.samplers import SAMPLERS
from ntp_dsl.language.parsing.partial_library import Key
from ntp_dsl.language.syntax import nodes
from ntp_dsl.language.syntax.nodes import Declaration, Expression, Generator, Statement
from ntp_dsl.language.syntax.visitors import callees, walk


def references(declaration: Declaration) -> frozenset[Key]:
    """Return the namespaces and names; a parameter or variable counts as a value of its name."""
    return frozenset(_references(declaration))


def _references(declaration: Declaration) -> Iterator[Key]:
    match declaration:
        case nodes.TypeDeclaration(parent=parent) if parent is not None:
            yield "type", parent.name
        case nodes.RecordDeclaration(fields=fields):
            yield from _types(fields)
        case nodes.ConstantDeclaration(type=type):
            yield "type", type.name
        case nodes.PredicateDeclaration(parameters=parameters, result=result):
            yield from _types(parameters)
            if result is not None:
                yield "type", result.name
        case nodes.ApiDeclaration(parameters=parameters):
            yield from _types(parameters)
        case nodes.ProgramDeclaration(parameters=parameters):
            yield from _types(parameters)
            yield from (("call", name) for name in callees(declaration))
        case nodes.TaskDeclaration():
            yield from _task(declaration)
    yield from _terms(expressions_of(declaration))


def expressions_of(declaration: Declaration) -> list[Expression | Generator | None]:
    """Return all conditions, loops and arguments of a declaration."""
    match declaration:
        case nodes.PredicateDeclaration(body=body):
            return [body]
        case nodes.ApiDeclaration(requires=requires, achieves=achieves):
            return [requires, achieves]
        case nodes.ProgramDeclaration(requires=requires, achieves=achieves, body=statements):
            return [requires, achieves, *(part for each in statements for part in statement_parts(each))]
        case nodes.TaskDeclaration(initially=initially, goal=goal, run=run, success=success):
            rows = goal.rows if isinstance(goal, nodes.GivenGoal) else ()
            given = (term for row in rows for term in row.terms)
            return [*initially, *given, *(run.arguments if run else ()), success]
    return []


def _types(parameters: Iterable[nodes.Parameter]) -> Iterator[Key]:
    return (("type", each.type.name) for each in parameters)


def _terms(expressions: Iterable[Expression | Generator | None]) -> Iterator[Key]:
    for expression in expressions:
        for each in walk(expression):
            if isinstance(each, nodes.Atom):
                yield "predicate", each.predicate
            elif isinstance(each, Generator):
                yield "type", each.iterable.id
            elif isinstance(each, nodes.Name):
                yield "value", each.id


def _task(task: nodes.TaskDeclaration) -> Iterator[Key]:
    for group in task.scene:
        yield "type", group.type.name
        yield "value", group.place
        for detail in group.details:
            yield "predicate", detail.name
            names = (each for each in detail.settings if isinstance(each, nodes.Name))
            yield from (("value", each.id) for each in names)
    if (sampler := task.sampler) is not None:
        kind = SAMPLERS.get(sampler.name)
        yield "type", sampler.result.name if sampler.result else kind.record if kind else ""
        yield from (("type", group) for group in sampler.groups)
    elif isinstance(task.goal, nodes.GivenGoal) and task.goal.result is not None:
        yield "type", task.goal.result.name
    if task.run is not None:
        yield "call", task.run.callee


def statement_parts(statement: Statement) -> Iterator[Expression | Generator]:
    """Yield the generators, conditions and arguments of a statement."""
    while not isinstance(statement, nodes.Call):
        yield statement.generator if isinstance(statement, nodes.For) else statement.condition
        statement = statement.body
    yield from statement.arguments
