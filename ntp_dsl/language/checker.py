"""From libraries to a registry: every mistake at once, or the proof that there is none."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

from ntp_dsl import registry
from ntp_dsl.language import contracts, hierarchy, syntax, tasks
from ntp_dsl.language.diagnostics import Diagnostic, SourceError
from ntp_dsl.language.formatter import hash_declaration
from ntp_dsl.language.names import Table, check_type, collect
from ntp_dsl.language.signatures import Names, check_parameters, si
from ntp_dsl.language.syntax import PYTHON
from ntp_dsl.language.typing_rules import Typing
from ntp_dsl.language.walks import callees


def check(
    *libraries: syntax.Library, sources: Mapping[Path | None, str] | None = None
) -> registry.Registry:
    """Check a library together with those it uses; `SourceError` carries every mistake.

    Args:
        libraries: the library that the registry is named after, then the libraries that it uses.
        sources: texts by path, for the excerpts in the error's message.
    """
    table, mistakes = examine(*libraries)
    if any(each.severity == "error" for each in mistakes):
        raise SourceError(mistakes, sources)
    return _register(libraries[0].name, table)


def examine(*libraries: syntax.Library) -> tuple[Table, Sequence[Diagnostic]]:
    """The names that the libraries declare, and everything that is wrong with them."""
    # Those that are used come first: where two declare one name, the user of the other is told.
    table = collect([*libraries[1:], libraries[0]])
    typing = Typing(table)
    for declaration in _declarations(table):
        _check_declaration(declaration, table, typing)
    # Where whole libraries are missing, nothing can be said of what contracts mean.
    if not table.missing:
        judged = [*table.predicates.values(), *table.programs.values()]
        contracts.check_contracts(table, judged)
        hierarchy.check_hierarchy(table, judged)
    return table, table.mistakes


def _declarations(table: Table) -> Iterator[syntax.Declaration]:
    yield from table.records.values()
    yield from table.constants.values()
    yield from table.predicates.values()
    yield from table.apis.values()
    yield from table.programs.values()
    yield from table.tasks.values()


def _check_declaration(declaration: syntax.Declaration, table: Table, typing: Typing) -> None:
    match declaration:
        case syntax.RecordDeclaration():
            check_parameters(table, declaration.fields)
        case syntax.ConstantDeclaration():
            if declaration.type.is_list or declaration.type.name not in table.types:
                if check_type(table, declaration.type):
                    message = "a constant is one thing of the scene"
                    table.report("E202", message, declaration.type.span)
        case syntax.PredicateDeclaration():
            names = check_parameters(table, declaration.parameters)
            if declaration.body is not None:
                typing.condition(declaration.body, names)
            if declaration.result is not None:
                check_type(table, declaration.result)
        case syntax.ApiDeclaration():
            _check_contract(declaration, table, typing)
        case syntax.ProgramDeclaration():
            names = _check_contract(declaration, table, typing)
            for statement in declaration.body:
                _check_statement(statement, names, table, typing)
            for callee in declaration.calls:
                typing.callee(callee.id, callee.span)
            _check_shape(declaration, table)
        case syntax.TaskDeclaration():
            tasks.check_task(declaration, table, typing)


def _check_contract(
    declaration: syntax.ApiDeclaration | syntax.ProgramDeclaration, table: Table, typing: Typing
) -> Names:
    names = check_parameters(table, declaration.parameters)
    for condition in (declaration.requires, declaration.achieves):
        if condition is not None:
            typing.condition(condition, names)
    return names


def _check_statement(
    statement: syntax.Statement, names: Names, table: Table, typing: Typing
) -> None:
    match statement:
        case syntax.For(generator, body):
            _check_statement(body, typing.generator(generator, names), table, typing)
        case syntax.When(condition, body):
            typing.condition(condition, names)
            _check_statement(body, names, table, typing)
        case syntax.Call():
            typing.call(statement, names)


def _check_shape(program: syntax.ProgramDeclaration, table: Table) -> None:
    if program.by is not None and program.by.id != PYTHON:
        message = f"a program has a body, or is decided by {PYTHON}"
        table.report("E112", message, program.by.span)
    elif program.by is not None and program.body:
        message = f"'{program.name}' is decided by {PYTHON}, so it has no body"
        help = f"say what it may call: calls {', '.join(callees(program))}"
        table.report("E408", message, program.body[0].span, help)
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


def _register(name: str, table: Table) -> registry.Registry:
    return registry.Registry(
        name=name,
        parents={
            each.name: each.parent.name if each.parent else None for each in table.types.values()
        },
        enums={each.name: each.members for each in table.enums.values()},
        records={each.name: _parameters(each.fields) for each in table.records.values()},
        constants={each.name: each.type.name for each in table.constants.values()},
        predicates=dict(table.predicates),
        apis={each.name: _api(each) for each in table.apis.values()},
        programs={each.name: _program(each) for each in table.programs.values()},
        tasks=dict(table.tasks),
    )


def _parameters(parameters: Sequence[syntax.Parameter]) -> tuple[registry.Parameter, ...]:
    return tuple(
        registry.Parameter(
            each.name, each.type.name, each.type.is_list, si(each.low), si(each.high)
        )
        for each in parameters
    )


def _api(declared: syntax.ApiDeclaration) -> registry.Api:
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


def _program(declared: syntax.ProgramDeclaration) -> registry.Program:
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
