"""Checks of what a demonstration can show of a program's lists."""

from __future__ import annotations

from collections.abc import Iterator

from ntp_dsl.language.diagnostics.diagnostics import Diagnostic
from ntp_dsl.language.logic.list_contracts import parts_about, unmentioned
from ntp_dsl.language.logic.preconditions import Contracts
from ntp_dsl.language.syntax.nodes import Field, Generator, ProgramDeclaration
from ntp_dsl.language.syntax.visitors import walk_statement


def check_lists(program: ProgramDeclaration, contracts: Contracts) -> Iterator[Diagnostic]:
    """Note the lists, and the fields of elements that its body needs, of which a contract says nothing."""
    if contracts.has_error(program):
        return
    table = contracts.table
    for parameter in program.parameters:
        if not parameter.type.is_list:
            continue
        name, of = parameter.name, parameter.type.name
        parts = parts_about(name, program.achieves)
        record = table.records.get(of)
        if not parts:
            taken = f"every {of} is taken" if of in table.types else "it is read as empty"
            message = f"nothing that '{program.name}' achieves is about '{name}': no demonstration shows it"
            help = f"say what is to hold of each element, all ... for x in {name}; else {taken}"
            yield Diagnostic("N404", message, parameter.span, help=help)
        elif record is not None:
            needed = _fields_of(program, name)
            fields = [each.name for each in record.fields if each.name in needed]
            for field in unmentioned(parts, of, fields, table.predicates):
                message = f"nothing that '{program.name}' achieves is about '{field}' of '{name}'"
                help = "it is read from what the hand does alone; to be sure of it, state it in `achieves`"
                yield Diagnostic("N405", message, parameter.span, help=help)


def _fields_of(program: ProgramDeclaration, name: str) -> set[str]:
    """Return the fields that a program's body takes of the elements of a list."""
    found: set[str] = set()
    for statement in program.body:
        terms = list(walk_statement(statement))
        loops = [each for each in terms if isinstance(each, Generator) and each.iterable.id == name]
        variables = {each.variable for each in loops}
        found |= {each.name for each in terms if isinstance(each, Field) and each.value.id in variables}
    return found
