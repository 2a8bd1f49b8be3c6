"""Checks of one declaration by itself: its names, types and shape."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import replace

from ntp_dsl.language.checks.condition_lints import check_conditions
from ntp_dsl.language.checks.given import check_state
from ntp_dsl.language.checks.sentences import check_placeholders
from ntp_dsl.language.checks.state_changes import check_definite
from ntp_dsl.language.checks.tasks import check_task
from ntp_dsl.language.checks.type_checker import TypeChecker
from ntp_dsl.language.diagnostics.checked import Checked
from ntp_dsl.language.diagnostics.diagnostics import Diagnostic, Fix
from ntp_dsl.language.names.signatures import Names, check_parameters
from ntp_dsl.language.names.symbol_table import SymbolTable, check_type
from ntp_dsl.language.syntax import nodes
from ntp_dsl.language.syntax.formatter import format_signature
from ntp_dsl.language.syntax.nodes import PYTHON, Span
from ntp_dsl.language.syntax.visitors import callees, innermost


def check_declaration(declaration: nodes.Declaration, table: SymbolTable) -> Iterator[Diagnostic]:
    """Check the names, types and shape of one declaration."""
    yield from _without_same_list(_check_meaning(declaration, table))
    yield from check_conditions(table, declaration)


def _without_same_list(found: Iterable[Diagnostic]) -> Iterator[Diagnostic]:
    """Drop a repeated E206 with the same fix: one parameter that should be a list, in several loops."""
    fixes: set[Fix] = set()
    for each in found:
        if each.code == "E206" and each.fix is not None:
            if each.fix in fixes:
                continue
            fixes.add(each.fix)
        yield each


def _check_meaning(declaration: nodes.Declaration, table: SymbolTable) -> Iterator[Diagnostic]:
    typing = TypeChecker(table)
    match declaration:
        case nodes.RecordDeclaration():
            yield from check_parameters(table, declaration.fields)
            for field in declaration.fields:
                if field.type.is_list or field.type.name in table.records:
                    message = f"'{field.name}' is no object, member or number, as the fields of a record are"
                    help = "give a program two lists, or a record more fields"
                    yield Diagnostic("E202", message, field.type.span, (), help)
        case nodes.ConstantDeclaration():
            if declaration.type.is_list or declaration.type.name not in table.types:
                if (yield from check_type(table, declaration.type)):
                    message = "a constant is one object of the scene"
                    yield Diagnostic("E202", message, declaration.type.span)
        case nodes.PredicateDeclaration():
            names = yield from check_parameters(table, declaration.parameters)
            if _is_reading(declaration, names, table):
                yield _no_result(declaration)
            elif declaration.body is not None:
                yield from typing.condition(declaration.body, names)
            if declaration.result is not None:
                yield from check_type(table, declaration.result)
            yield from check_state(declaration, table)
        case nodes.ApiDeclaration():
            yield from _check_contract(declaration, table, typing)
            yield from check_placeholders(declaration, table)
            yield from check_definite(declaration, table)
        case nodes.ProgramDeclaration():
            names = yield from _check_contract(declaration, table, typing)
            yield from check_placeholders(declaration, table)
            for statement in declaration.body:
                yield from _check_statement(statement, names, table, typing)
            for callee in declaration.calls:
                yield from typing.callee(callee.id, callee.span)
            yield from _check_shape(declaration)
        case nodes.TaskDeclaration():
            yield from check_task(declaration, table, typing)


def _is_reading(declaration: nodes.PredicateDeclaration, names: Names, table: SymbolTable) -> bool:
    """Recognise `predicate drink(cup: Cup): Drink`, where `-> Drink` is meant."""
    body = declaration.body
    return isinstance(body, nodes.Name) and body.id not in names and body.id in table.type_names()


def _no_result(declaration: nodes.PredicateDeclaration) -> Diagnostic:
    body = declaration.body
    assert isinstance(body, nodes.Name)
    start, end = declaration.name_span, body.span
    whole = Span(start.path, start.line, start.column, end.end_line, end.end_column)
    meant = replace(declaration, body=None, result=nodes.TypeName(body.id))
    fix = Fix(whole, format_signature(meant), certain=True) if start.line == end.line else None
    message = f"the type of a reading follows '->': {format_signature(meant)}"
    return Diagnostic("E205", message, body.span, fix=fix, name=body.id)


def _check_contract(
    declaration: nodes.ApiDeclaration | nodes.ProgramDeclaration, table: SymbolTable, typing: TypeChecker
) -> Checked[Names]:
    names = yield from check_parameters(table, declaration.parameters)
    for condition in (declaration.requires, declaration.achieves):
        if condition is not None:
            yield from typing.condition(condition, names)
    return names


def _check_statement(
    statement: nodes.Statement, names: Names, table: SymbolTable, typing: TypeChecker
) -> Iterator[Diagnostic]:
    match statement:
        case nodes.For(generator, body):
            inner = yield from typing.generator(generator, names, statement)
            yield from _check_statement(body, inner, table, typing)
        case nodes.When(condition, body, is_else):
            if not is_else:  # else it is checked where it is written
                yield from typing.condition(condition, names)
            yield from _check_statement(body, names, table, typing)
        case nodes.Call():
            yield from typing.call(statement, names)


def _check_shape(program: nodes.ProgramDeclaration) -> Iterator[Diagnostic]:
    if program.by is not None and program.by.id != PYTHON:
        message = f"a program has a body, or is decided by {PYTHON}"
        yield Diagnostic("E112", message, program.by.span)
    elif program.by is not None and program.body:
        message = f"'{program.name}' is decided by {PYTHON}, so it has no body"
        help = f"say what it may call: calls {', '.join(callees(program))}"
        first, last = program.body[0].span, innermost(program.body[-1]).span
        whole = Span(first.path, first.line, first.column, last.end_line, last.end_column)
        fix = Fix(whole, f"calls {', '.join(callees(program))}")
        yield Diagnostic("E408", message, first, help=help, fix=fix)
    elif program.by is None and program.calls:
        message = f"'{program.name}' has a body, which says what it calls"
        help = f"an expert in Python is declared: program {program.name}(...) by {PYTHON}:"
        yield Diagnostic("E408", message, program.calls[0].span, help=help)
    elif not callees(program):
        message = f"program '{program.name}' calls nothing"
        help = "a program has at least one call"
        if program.by is not None:
            help = "say what it may call: calls pick, place"
        yield Diagnostic("E405", message, program.name_span, help=help)
