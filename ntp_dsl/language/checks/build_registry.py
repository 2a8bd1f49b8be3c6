"""From what a library without errors sees to its registry."""

from __future__ import annotations

from collections.abc import Sequence

from ntp_dsl.language.names.signatures import si
from ntp_dsl.language.names.symbol_table import SymbolTable
from ntp_dsl.language.registry import Api, Parameter, Program, Registry
from ntp_dsl.language.syntax import nodes
from ntp_dsl.language.syntax.formatter import hash_declaration
from ntp_dsl.language.syntax.visitors import callees


def build_registry(name: str, table: SymbolTable) -> Registry:
    """Return the registry of a library without errors."""
    return Registry(
        name=name,
        parents={each.name: each.parent.name if each.parent else None for each in table.types.values()},
        enums={each.name: each.members for each in table.enums.values()},
        records={each.name: _parameters(each.fields) for each in table.records.values()},
        constants={each.name: each.type.name for each in table.constants.values()},
        predicates=dict(table.predicates),
        apis={each.name: _api(each) for each in table.apis.values()},
        programs={each.name: _program(each) for each in table.programs.values()},
        tasks=dict(table.tasks),
    )


def _parameters(parameters: Sequence[nodes.Parameter]) -> tuple[Parameter, ...]:
    return tuple(
        Parameter(each.name, each.type.name, each.type.is_list, si(each.low), si(each.high))
        for each in parameters
    )


def _api(declared: nodes.ApiDeclaration) -> Api:
    return Api(
        name=declared.name,
        parameters=_parameters(declared.parameters),
        requires=declared.requires,
        achieves=declared.achieves,
        hash=hash_declaration(declared),
        docstring=declared.docstring,
        says=tuple(each.value for each in declared.says),
        span=declared.name_span,
        skill=declared.by.id if declared.by else declared.name,
    )


def _program(declared: nodes.ProgramDeclaration) -> Program:
    return Program(
        name=declared.name,
        parameters=_parameters(declared.parameters),
        requires=declared.requires,
        achieves=declared.achieves,
        hash=hash_declaration(declared),
        docstring=declared.docstring,
        says=tuple(each.value for each in declared.says),
        span=declared.name_span,
        body=declared.body,
        callees=callees(declared),
        in_python=declared.by is not None,
    )
