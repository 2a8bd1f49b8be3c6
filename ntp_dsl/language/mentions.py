"""What a declaration speaks of: every name in it that another declaration may have declared."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from ntp_dsl.language import syntax
from ntp_dsl.language.drafts import Key
from ntp_dsl.language.samplers import SAMPLERS
from ntp_dsl.language.syntax import Declaration, Expression, Generator, Statement
from ntp_dsl.language.walks import callees, everything


def mentions(declaration: Declaration) -> frozenset[Key]:
    """Namespaces and names; a parameter or variable counts as a value of its name."""
    return frozenset(_mentions(declaration))


def _mentions(declaration: Declaration) -> Iterator[Key]:
    match declaration:
        case syntax.TypeDeclaration(parent=parent) if parent is not None:
            yield "type", parent.name
        case syntax.RecordDeclaration(fields=fields):
            yield from _types(fields)
        case syntax.ConstantDeclaration(type=type):
            yield "type", type.name
        case syntax.PredicateDeclaration(parameters=parameters, result=result):
            yield from _types(parameters)
            if result is not None:
                yield "type", result.name
        case syntax.ApiDeclaration(parameters=parameters):
            yield from _types(parameters)
        case syntax.ProgramDeclaration(parameters=parameters):
            yield from _types(parameters)
            yield from (("call", name) for name in callees(declaration))
        case syntax.TaskDeclaration():
            yield from _task(declaration)
    yield from _terms(said(declaration))


def said(declaration: Declaration) -> list[Expression | Generator | None]:
    """All conditions, loops and arguments of a declaration."""
    match declaration:
        case syntax.PredicateDeclaration(body=body):
            return [body]
        case syntax.ApiDeclaration(requires=requires, achieves=achieves):
            return [requires, achieves]
        case syntax.ProgramDeclaration(requires=requires, achieves=achieves, body=statements):
            return [requires, achieves, *(part for each in statements for part in inside(each))]
        case syntax.TaskDeclaration(run=run, success=success):
            return [*(run.arguments if run else ()), success]
    return []


def _types(parameters: Iterable[syntax.Parameter]) -> Iterator[Key]:
    return (("type", each.type.name) for each in parameters)


def _terms(expressions: Iterable[Expression | Generator | None]) -> Iterator[Key]:
    for expression in expressions:
        for each in everything(expression):
            if isinstance(each, syntax.Atom):
                yield "predicate", each.predicate
            elif isinstance(each, Generator):
                yield "type", each.iterable.id
            elif isinstance(each, syntax.Name):
                yield "value", each.id


def _task(task: syntax.TaskDeclaration) -> Iterator[Key]:
    for group in task.scene:
        yield "type", group.type.name
        yield "value", group.place
        for detail in group.details:
            yield "predicate", detail.name
            names = (each for each in detail.settings if isinstance(each, syntax.Name))
            yield from (("value", each.id) for each in names)
    if task.goal is not None:
        kind = SAMPLERS.get(task.goal.name)
        yield "type", task.goal.result.name if task.goal.result else kind.record if kind else ""
        yield from (("type", group) for group in task.goal.groups)
    if task.run is not None:
        yield "call", task.run.callee


def inside(statement: Statement) -> Iterator[Expression | Generator]:
    """What the loops, the conditions and the call of a statement are made of."""
    while not isinstance(statement, syntax.Call):
        yield statement.generator if isinstance(statement, syntax.For) else statement.condition
        statement = statement.body
    yield from statement.arguments
