"""Checks of a task's goal: that it can be drawn from the scene, with its options, into a record that fits."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace

from ntp_dsl.language.diagnostics.checked import Checked, outcome
from ntp_dsl.language.diagnostics.diagnostics import Diagnostic, Fix, Note, unknown
from ntp_dsl.language.names.samplers import SAMPLERS, SamplerKind
from ntp_dsl.language.names.signatures import are_given, counted, fits, leading_span, with_article
from ntp_dsl.language.names.symbol_table import SymbolTable
from ntp_dsl.language.repairs.task_repairs import (
    filled,
    fills,
    other_groups,
    other_range,
    other_record,
    with_groups,
    with_options,
    without,
)
from ntp_dsl.language.syntax.formatter import format_sampler
from ntp_dsl.language.syntax.nodes import (
    PYTHON,
    Option,
    RecordDeclaration,
    Sampler,
    SceneGroup,
    Span,
    TaskDeclaration,
    TypeName,
)

LENGTHS = {kind.length for kind in SAMPLERS.values()} | {"count", "number", "size", "n"}


def check_goal(goal: Sampler, task: TaskDeclaration, table: SymbolTable) -> Checked[str]:
    """Return the record that the goal is a list of; "" where that cannot be told."""
    span = leading_span(goal.span, goal.name)
    record = None if goal.result is None else (yield from check_result(goal.result, table))
    sources = yield from _check_sources(goal, task, table)
    if goal.by is not None:
        yield from _check_python(goal, task, table)
        yield from _check_ranges(goal)
        return record.name if record else ""
    kind = SAMPLERS.get(goal.name)
    if kind is None:
        help = "a sampler in Python is written: NAME(...) -> list[Placement] by python"
        yield unknown("E108", "there is no sampler", goal.name, span, SAMPLERS, help)
        return record.name if record else ""
    if goal.result is None:
        record = table.records.get(kind.record)
        if record is None:
            message = f"'{goal.name}' draws a list of {kind.record}, and no such record is declared"
            help = "write 'use tabletop' above"
            yield Diagnostic("E108", message, span, help=help, name=kind.record)
    options = yield from _check_options(goal, kind, sources)
    drawn = record.name if record else ""
    if sources is None:
        return drawn
    found = [*_check_number(goal, kind, sources, record, task, table)]
    yield from found
    if found:
        return drawn
    if record is not None:
        found = [*_check_fields(goal, kind, record, sources, task, table)]
        yield from found
        if found:
            return ""  # it is unclear which record is meant
    counts = [count for _, count in sources]
    if options is not None and all(counts):
        for name, message, better in kind.flaws(options, counts):
            place = options[name].span if name else span
            fix = other_range(options[name], better) if name else None
            yield Diagnostic("E502", message, place, fix=fix)
    return drawn


def check_result(result: TypeName, table: SymbolTable) -> Checked[RecordDeclaration | None]:
    """Return the record of `-> list[RECORD]`, of which a goal is a list."""
    record = table.records.get(result.name)
    if record is None:
        yield unknown("E103", "there is no record", result.name, result.span, table.records)
    elif not result.is_list:
        message = f"a goal is a list: list[{record.name}]"
        fix = Fix(result.span, f"list[{record.name}]", certain=True)
        yield Diagnostic("E202", message, result.span, fix=fix)
    return record


def _check_python(goal: Sampler, task: TaskDeclaration, table: SymbolTable) -> Iterator[Diagnostic]:
    assert goal.by is not None
    if goal.by.id != PYTHON:
        message = f"a goal is drawn by a built-in sampler, or by {PYTHON}"
        yield Diagnostic("E112", message, goal.by.span)
    elif goal.result is None:
        message = f"'{goal.name}' does not say what it draws"
        help = "for example: -> list[Placement], before 'by python'"
        program = table.programs.get(task.run.callee) if task.run else None
        lists = [each.type for each in program.parameters if each.type.is_list] if program else []
        typed = replace(goal, result=lists[0]) if len(lists) == 1 else None
        fix = Fix(goal.span, format_sampler(typed)) if typed else None
        yield Diagnostic("E502", message, leading_span(goal.span, goal.name), help=help, fix=fix)


Source = tuple[TypeName, int]  # a type, and how many objects there are at least


def _check_sources(goal: Sampler, task: TaskDeclaration, table: SymbolTable) -> Checked[list[Source] | None]:
    """Return the groups of the scene, or enumerations, that a sampler draws from."""
    declared: dict[str, SceneGroup] = {group.name: group for group in task.scene}
    sources: list[Source] = []
    missing = False
    for index, name in enumerate(goal.groups):
        if name in declared:
            sources.append((declared[name].type, declared[name].count))
        elif name in table.enums:
            sources.append((TypeName(name), len(table.enums[name].members)))
        else:
            span = goal.group_spans[index] if goal.group_spans else goal.span
            known = [*declared, *table.enums]
            yield unknown("E106", "the scene has no group", name, span, known)
            missing = True
    return None if missing else sources


def _check_number(
    goal: Sampler,
    kind: SamplerKind,
    sources: list[Source],
    record: RecordDeclaration | None,
    task: TaskDeclaration,
    table: SymbolTable,
) -> Iterator[Diagnostic]:
    wanted = len(kind.sources)
    span = leading_span(goal.span, goal.name)
    help = f"it is written: {goal.name}({', '.join(kind.sources)}, ...), where each is a group of the scene"
    if not sources:
        message = f"'{goal.name}' draws from the scene; name the groups that it may use"
        yield Diagnostic("E502", message, span, help=help, fix=with_groups(goal, kind, record, task, table))
    elif len(sources) < wanted or (len(sources) > wanted and not kind.many_sources):
        message = f"'{goal.name}' draws from {counted(wanted, 'group')}, and {are_given(len(sources))}"
        yield Diagnostic("E201", message, span, help=help, fix=with_groups(goal, kind, record, task, table))


def _check_fields(
    goal: Sampler,
    kind: SamplerKind,
    record: RecordDeclaration,
    sources: list[Source],
    task: TaskDeclaration,
    table: SymbolTable,
) -> Iterator[Diagnostic]:
    """Check that a pair becomes the record's two fields; of a tower, each object may be either."""
    span = goal.result.span if goal.result else leading_span(goal.span, goal.name)
    note = Note(f"'{record.name}' is declared here", record.name_span)
    types = [type for type, _ in sources]
    if len(record.fields) != 2:
        message = f"'{goal.name}' fills two fields, and a {record.name} has {len(record.fields)}"
        yield Diagnostic("E202", message, span, (note,), fix=other_record(goal, kind, types, task, table))
        return
    wanted = filled(kind, types, record)
    index = next((i for i, (type, field) in enumerate(wanted) if not fits(table, type, field.type)), None)
    if index is None:
        return
    type, field = wanted[index]
    message = f"'{field.name}' is {with_article(field.type)}, and each of these is {with_article(type)}"
    is_clear = len(types) == 1 or not kind.many_sources  # which of the groups is wrong
    others = other_groups(goal, kind, index, record, task, table) if is_clear else []
    if not kind.many_sources and fills(kind, types[::-1], record, table):
        fix = Fix(goal.span, format_sampler(replace(goal, groups=goal.groups[::-1])), certain=True)
        place = goal.group_spans[0] if goal.group_spans else span
        yield Diagnostic("E202", message, place, (note,), "in the other order they fit", fix)
    elif len(others) == 1 and goal.group_spans:
        place = goal.group_spans[0 if kind.many_sources else index]
        help = f"'{others[0]}' would fit"
        yield Diagnostic("E202", message, place, (note,), help, Fix(place, others[0]))
    else:
        other = other_record(goal, kind, types, task, table)
        help = f"did you mean {other.replacement}?" if other else ""
        yield Diagnostic("E202", message, span, (note,), help, other)


def _check_options(
    goal: Sampler, kind: SamplerKind, sources: list[Source] | None
) -> Checked[Mapping[str, Option] | None]:
    """Return the options by name; None where something is wrong with them."""
    found = [_unknown_option(each, goal, kind) for each in goal.options if each.name not in kind.options]
    options, wrong = outcome(_check_ranges(goal))
    yield from (found := [*found, *wrong])
    missing = [name for name in kind.needed if name not in options]
    if missing and not found:
        options_needed = f"the option{'s' * (len(missing) > 1)} {' and '.join(map(repr, missing))}"
        message = f"'{goal.name}' needs {options_needed}"
        whole = format_sampler(with_options(goal, kind, [count for _, count in sources or ()]))
        fix = Fix(goal.span, whole)
        yield Diagnostic(
            "E502", message, leading_span(goal.span, goal.name), help=f"for example: {whole}", fix=fix
        )
    return None if missing or found else options


def _unknown_option(option: Option, goal: Sampler, kind: SamplerKind) -> Diagnostic:
    span = _option_span(option)
    wrong = unknown("E109", f"'{goal.name}' has no option", option.name, span, kind.options)
    if option.name in LENGTHS and kind.length not in {each.name for each in goal.options}:
        help = f"its length is called '{kind.length}'"
        return replace(wrong, help=help, fix=Fix(span, kind.length))
    return wrong


def _check_ranges(goal: Sampler) -> Checked[Mapping[str, Option]]:
    options: dict[str, Option] = {}
    for option in goal.options:
        if option.name in options:
            message = f"'{option.name}' is set twice"
            help, fix = "one of the two is enough", without(option, goal)
            yield Diagnostic("E305", message, _option_span(option), help=help, fix=fix)
        elif option.low > option.high:
            message = f"{option.low}..{option.high} is empty: it ends below its start"
            fix = other_range(option, (option.high, option.low))
            yield Diagnostic("E502", message, option.span, help="the lower number comes first", fix=fix)
        options.setdefault(option.name, option)
    return options


def _option_span(option: Option) -> Span:
    return leading_span(option.span, option.name)
