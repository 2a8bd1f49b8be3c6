"""From libraries to a registry: every mistake at once, or the proof that there is none."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

from ntp_dsl.language import registry
from ntp_dsl.language.checks.check_library import examine
from ntp_dsl.language.diagnostics.diagnostics import Diagnostic, SourceError
from ntp_dsl.language.names.signatures import si
from ntp_dsl.language.names.symbol_table import Table
from ntp_dsl.language.names.use_statements import unknown_library
from ntp_dsl.language.names.visibility import Unit, collect
from ntp_dsl.language.parsing.partial_library import Draft
from ntp_dsl.language.syntax import nodes
from ntp_dsl.language.syntax.formatter import hash_declaration
from ntp_dsl.language.syntax.visitors import callees


def check(*libraries: nodes.Library, sources: Mapping[Path | None, str] | None = None) -> registry.Registry:
    """Check a library together with those it uses; `SourceError` carries every mistake.

    Args:
        libraries: the library that the registry is named after, then the libraries that it uses.
        sources: texts by path, for the excerpts in the error's message.
    """
    units, mistakes = link([Draft.of(library) for library in libraries])
    mistakes += examine(units)
    if any(each.severity == "error" for each in mistakes):
        raise SourceError(mistakes, sources)
    table = Table()
    collect(units, 0, table)
    return _register(libraries[0].name, table)


def link(drafts: Sequence[Draft]) -> tuple[list[Unit], list[Diagnostic]]:
    """Find what each library uses among the others, by name."""
    known = {draft.name: index for index, draft in reversed([*enumerate(drafts)])}
    units: list[Unit] = []
    mistakes: list[Diagnostic] = []
    for draft in drafts:
        used: list[int | None] = []
        for use in draft.uses:
            meant = use.library
            if meant not in known:
                mistakes.append(unknown_library(use, known))
                fix = mistakes[-1].fix
                meant = fix.replacement if fix else ""
            used.append(known.get(meant))
        units.append(Unit(draft, tuple(used)))
    return units, mistakes


def _register(name: str, table: Table) -> registry.Registry:
    return registry.Registry(
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


def _parameters(parameters: Sequence[nodes.Parameter]) -> tuple[registry.Parameter, ...]:
    return tuple(
        registry.Parameter(each.name, each.type.name, each.type.is_list, si(each.low), si(each.high))
        for each in parameters
    )


def _api(declared: nodes.ApiDeclaration) -> registry.Api:
    return registry.Api(
        name=declared.name,
        parameters=_parameters(declared.parameters),
        requires=declared.requires,
        achieves=declared.achieves,
        hash=hash_declaration(declared),
        docstring=declared.docstring,
        span=declared.name_span,
        skill=declared.by.id if declared.by else declared.name,
    )


def _program(declared: nodes.ProgramDeclaration) -> registry.Program:
    return registry.Program(
        name=declared.name,
        parameters=_parameters(declared.parameters),
        requires=declared.requires,
        achieves=declared.achieves,
        hash=hash_declaration(declared),
        docstring=declared.docstring,
        span=declared.name_span,
        body=declared.body,
        callees=callees(declared),
        in_python=declared.by is not None,
    )
