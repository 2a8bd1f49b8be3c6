"""Checks of what a task gives in so many words: a goal, and the facts of the state that hold at the start."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from ntp_dsl.language.checks.goals import check_result
from ntp_dsl.language.checks.scenes import GOAL, named_objects
from ntp_dsl.language.checks.type_checker import TypeChecker
from ntp_dsl.language.diagnostics.checked import Checked
from ntp_dsl.language.diagnostics.diagnostics import Diagnostic, Note
from ntp_dsl.language.names.signatures import are_given, counted, fits, leading_span, si, with_article
from ntp_dsl.language.names.symbol_table import SymbolTable
from ntp_dsl.language.syntax import nodes
from ntp_dsl.language.syntax.formatter import format_expression
from ntp_dsl.language.syntax.nodes import STATE, GivenGoal, RecordDeclaration, Row, TaskDeclaration


def check_given_goal(
    goal: GivenGoal, task: TaskDeclaration, table: SymbolTable, typing: TypeChecker
) -> Checked[str]:
    """Return the record that the goal is a list of; "" where that cannot be told."""
    record = yield from _record(goal, task, table)
    for row in goal.rows:
        yield from _check_row(row, record, task, table, typing)
    return record.name if record else ""


def _record(goal: GivenGoal, task: TaskDeclaration, table: SymbolTable) -> Checked[RecordDeclaration | None]:
    """Return what the goal says it is a list of, or what the program that runs takes in its place."""
    if goal.result is not None:
        return (yield from check_result(goal.result, table))
    program = table.programs.get(task.run.callee) if task.run else None
    taken = (
        [
            table.records[parameter.type.name]
            for parameter, term in zip(program.parameters, task.run.arguments, strict=False)
            if term == nodes.Name(GOAL) and parameter.type.name in table.records
        ]
        if program and task.run
        else []
    )
    if taken:
        return taken[0]
    message = "the record of this goal is not known: no program takes it"
    help = "pass it to the program that runs, or say what it is a list of: ... -> list[Placement]"
    yield Diagnostic("E502", message, goal.span, help=help)
    return None


def _check_row(
    row: Row,
    record: RecordDeclaration | None,
    task: TaskDeclaration,
    table: SymbolTable,
    typing: TypeChecker,
) -> Iterator[Diagnostic]:
    names = dict(named_objects(task))
    fields = record.fields if record else ()
    if record is not None and len(row.terms) != len(fields):
        note = Note(f"'{record.name}' is declared here", record.name_span)
        message = f"a {record.name} has {counted(len(fields), 'field')}, and {are_given(len(row.terms))}"
        yield Diagnostic("E201", message, row.span, (note,))
        return
    for index, term in enumerate(row.terms):
        expected = fields[index].type if fields else None
        if not isinstance(term, nodes.Name | nodes.Number):
            message = "a goal that is given names objects, members and numbers"
            yield Diagnostic("E205", message, term.span)
            continue
        found = yield from typing.value(term, names, expected)
        if fields and isinstance(term, nodes.Number):
            yield from _check_range(term, fields[index])
        if found is None or expected is None or fits(table, found, expected):
            continue
        message = f"'{fields[index].name}' is {with_article(expected)}, and this is {with_article(found)}"
        yield Diagnostic("E202", message, term.span)


def _check_range(number: nodes.Number, field: nodes.Parameter) -> Iterator[Diagnostic]:
    """Check that a number is in the range that its field declares."""
    value, low, high = (si(each) for each in (number, field.low, field.high))
    if value is None or low is None or high is None or low <= value <= high:
        return
    assert field.low is not None and field.high is not None
    bounds = f"{format_expression(field.low)} .. {format_expression(field.high)}"
    message = f"'{field.name}' is in {bounds}, and this is {format_expression(number)}"
    yield Diagnostic("E504", message, number.span, (Note("declared here", field.span),))


def check_initially(task: TaskDeclaration, table: SymbolTable, typing: TypeChecker) -> Iterator[Diagnostic]:
    """Check that what holds at the start is of the state, and of objects that the scene has."""
    groups = {group.name: nodes.TypeName(group.type.name) for group in task.scene}
    names = {**groups, **dict(named_objects(task))}
    for fact in task.facts:
        found = [*typing.condition(fact, names)]
        if task.shared and found and not task.initially:
            message = f"of the facts at the start of '{task.shared.task}': {found[0].message}"
            yield replace(found[0], message=message, span=task.shared.task_span, fix=None)
            continue
        yield from found
        declared = table.predicates.get(fact.predicate)
        for term in fact.arguments:
            if not found and not isinstance(term, nodes.Name):
                found = [Diagnostic("E205", "a fact at the start names objects and members", term.span)]
                yield from found
        if not found and declared is not None and not declared.is_state:
            message = f"'{fact.predicate}' is not of the state, so that a scene cannot set it"
            help = "where objects start is said in the scene"
            if declared.body is not None:
                help = "it is composed of others: list those of them that are of the state"
            note = Note("declared here", declared.name_span)
            yield Diagnostic("E504", message, leading_span(fact.span, fact.predicate), (note,), help)


def check_state(declared: nodes.PredicateDeclaration, table: SymbolTable) -> Iterator[Diagnostic]:
    """Check that a predicate of the state is true or false, and about objects and members."""
    if not declared.is_state:
        return
    if declared.result is not None:
        message = f"what is of the {STATE} is true or false, and this is a reading"
        help = "for several values write a predicate of the object and an enumeration"
        yield Diagnostic("E112", message, declared.result.span, help=help)
    for parameter in declared.parameters:
        kind = parameter.type
        if kind.is_list or not (kind.name in table.types or kind.name in table.enums):
            message = f"what is of the {STATE} is about objects and members, and '{parameter.name}' is"
            yield Diagnostic("E202", f"{message} {with_article(kind)}", parameter.type.span)
