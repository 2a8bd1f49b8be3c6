"""What is wrong with one declaration, given the table of all: its names, types and shape."""

from __future__ import annotations

from dataclasses import replace

from ntp_dsl.language.checks import tasks
from ntp_dsl.language.checks.condition_lints import check_conditions
from ntp_dsl.language.checks.type_checker import Typing
from ntp_dsl.language.diagnostics.diagnostics import Fix
from ntp_dsl.language.names.signatures import Names, check_parameters
from ntp_dsl.language.names.symbol_table import Table, check_type
from ntp_dsl.language.syntax import nodes
from ntp_dsl.language.syntax.formatter import format_signature
from ntp_dsl.language.syntax.nodes import PYTHON, Span
from ntp_dsl.language.syntax.visitors import callees, innermost


def check_declaration(declaration: nodes.Declaration, table: Table) -> None:
    """Leave in the table what is wrong with it."""
    typing = Typing(table)
    match declaration:
        case nodes.RecordDeclaration():
            check_parameters(table, declaration.fields)
        case nodes.ConstantDeclaration():
            if declaration.type.is_list or declaration.type.name not in table.types:
                if check_type(table, declaration.type):
                    message = "a constant is one thing of the scene"
                    table.report("E202", message, declaration.type.span)
        case nodes.PredicateDeclaration():
            names = check_parameters(table, declaration.parameters)
            if declaration.body is not None and not _is_reading(declaration, names, table):
                typing.condition(declaration.body, names)
            if declaration.result is not None:
                check_type(table, declaration.result)
        case nodes.ApiDeclaration():
            _check_contract(declaration, table, typing)
        case nodes.ProgramDeclaration():
            names = _check_contract(declaration, table, typing)
            for statement in declaration.body:
                _check_statement(statement, names, table, typing)
            for callee in declaration.calls:
                typing.callee(callee.id, callee.span)
            _check_shape(declaration, table)
        case nodes.TaskDeclaration():
            tasks.check_task(declaration, table, typing)
    check_conditions(table, declaration)


def _is_reading(declaration: nodes.PredicateDeclaration, names: Names, table: Table) -> bool:
    """`predicate drink(cup: Cup): Drink`, where `-> Drink` is meant."""
    body = declaration.body
    if not isinstance(body, nodes.Name) or body.id in names or body.id not in table.type_names():
        return False
    start, end = declaration.name_span, body.span
    whole = Span(start.path, start.line, start.column, end.end_line, end.end_column)
    meant = replace(declaration, body=None, result=nodes.TypeName(body.id))
    fix = Fix(whole, format_signature(meant)) if start.line == end.line else None
    message = f"what a reading is, is said after '->': {format_signature(meant)}"
    table.report("E205", message, body.span, fix=fix, name=body.id)
    return True


def _check_contract(
    declaration: nodes.ApiDeclaration | nodes.ProgramDeclaration, table: Table, typing: Typing
) -> Names:
    names = check_parameters(table, declaration.parameters)
    for condition in (declaration.requires, declaration.achieves):
        if condition is not None:
            typing.condition(condition, names)
    return names


def _check_statement(statement: nodes.Statement, names: Names, table: Table, typing: Typing) -> None:
    match statement:
        case nodes.For(generator, body):
            _check_statement(body, typing.generator(generator, names, statement), table, typing)
        case nodes.When(condition, body):
            typing.condition(condition, names)
            _check_statement(body, names, table, typing)
        case nodes.Call():
            typing.call(statement, names)


def _check_shape(program: nodes.ProgramDeclaration, table: Table) -> None:
    if program.by is not None and program.by.id != PYTHON:
        message = f"a program has a body, or is decided by {PYTHON}"
        table.report("E112", message, program.by.span)
    elif program.by is not None and program.body:
        message = f"'{program.name}' is decided by {PYTHON}, so it has no body"
        help = f"say what it may call: calls {', '.join(callees(program))}"
        first, last = program.body[0].span, innermost(program.body[-1]).span
        whole = Span(first.path, first.line, first.column, last.end_line, last.end_column)
        fix = Fix(whole, f"calls {', '.join(callees(program))}")
        table.report("E408", message, first, help, fix=fix)
    elif program.by is None and program.calls:
        message = f"'{program.name}' has a body, which says what it calls"
        help = f"an expert in Python is declared: program {program.name}(...) by {PYTHON}:"
        table.report("E408", message, program.calls[0].span, help)
    elif not callees(program):
        message = f"program '{program.name}' calls nothing"
        help = "a program has at least one call"
        if program.by is not None:
            help = "say what it may call: calls pick, place"
        table.report("E405", message, program.name_span, help)
