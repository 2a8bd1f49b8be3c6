"""Whether a goal can be drawn: from what the scene has, with the knobs there are, into a record that fits."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from ntp_dsl.language.diagnostics.diagnostics import Fix, Note, unknown
from ntp_dsl.language.names.samplers import SAMPLERS, SamplerKind
from ntp_dsl.language.names.signatures import fits, head, phrase
from ntp_dsl.language.names.symbol_table import Table
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


def check_goal(goal: Sampler, task: TaskDeclaration, table: Table) -> str:
    """What the goal is a list of; nothing where that cannot be told."""
    span = head(goal.span, goal.name)
    record = _check_result(goal, table)
    sources = _check_sources(goal, task, table)
    if goal.by is not None:
        _check_python(goal, task, table)
        _check_ranges(goal, table)
        return record.name if record else ""
    kind = SAMPLERS.get(goal.name)
    if kind is None:
        help = "a function of your own is written: NAME(...) -> list[Placement] by python"
        table.mistakes.append(unknown("E108", "there is no sampler", goal.name, span, SAMPLERS, help))
        return record.name if record else ""
    if goal.result is None:
        record = table.records.get(kind.record)
        if record is None:
            message = f"'{goal.name}' draws a list of {kind.record}, and no such record is declared"
            help = "write 'use tabletop' above"
            table.report("E108", message, span, help, name=kind.record)
    options = _check_options(goal, kind, sources, table)
    if sources is not None and _check_number(goal, kind, sources, record, task, table):
        if record is not None and not _check_fields(goal, kind, record, sources, task, table):
            return ""  # nobody can tell what is meant
        if options is not None and all(count for _, count in sources):
            for name, message, better in kind.flaws(options, [count for _, count in sources]):
                place = options[name].span if name else span
                fix = other_range(options[name], better) if name else None
                table.report("E502", message, place, fix=fix)
    return record.name if record else ""


def _check_result(goal: Sampler, table: Table) -> RecordDeclaration | None:
    if goal.result is None:
        return None
    record = table.records.get(goal.result.name)
    if record is None:
        known = table.records
        table.mistakes.append(
            unknown("E103", "there is no record", goal.result.name, goal.result.span, known)
        )
    elif not goal.result.is_list:
        message = f"a goal is a list: list[{record.name}]"
        fix = Fix(goal.result.span, f"list[{record.name}]")
        table.report("E202", message, goal.result.span, fix=fix)
    return record


def _check_python(goal: Sampler, task: TaskDeclaration, table: Table) -> None:
    assert goal.by is not None
    if goal.by.id != PYTHON:
        message = f"a goal is drawn by a sampler that there is, or by {PYTHON}"
        table.report("E112", message, goal.by.span)
    elif goal.result is None:
        message = f"'{goal.name}' does not say what it draws"
        help = "for example: -> list[Placement], before 'by python'"
        program = table.programs.get(task.run.callee) if task.run else None
        lists = [each.type for each in program.parameters if each.type.is_list] if program else []
        typed = replace(goal, result=lists[0]) if len(lists) == 1 else None
        fix = Fix(goal.span, format_sampler(typed)) if typed else None
        table.report("E502", message, head(goal.span, goal.name), help, fix=fix)


Source = tuple[TypeName, int]  # of what type, and how many at least


def _check_sources(goal: Sampler, task: TaskDeclaration, table: Table) -> list[Source] | None:
    """The groups of the scene, or enumerations, that a sampler draws from."""
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
            table.mistakes.append(unknown("E106", "the scene has no group", name, span, known))
            missing = True
    return None if missing else sources


def _check_number(
    goal: Sampler,
    kind: SamplerKind,
    sources: list[Source],
    record: RecordDeclaration | None,
    task: TaskDeclaration,
    table: Table,
) -> bool:
    wanted = len(kind.sources)
    span = head(goal.span, goal.name)
    if not sources:
        message = f"'{goal.name}' is to draw from the scene; name the groups that it may use"
        help = f"{goal.name}({', '.join(kind.sources)}, ...)"
        table.report("E502", message, span, help, fix=with_groups(goal, kind, record, task, table))
        return False
    if len(sources) == wanted or (kind.many_sources and len(sources) > wanted):
        return True
    message = f"'{goal.name}' draws from {wanted}, here are {len(sources)}"
    help = f"{goal.name}({', '.join(kind.sources)}, ...)"
    table.report("E201", message, span, help, fix=with_groups(goal, kind, record, task, table))
    return False


def _check_fields(
    goal: Sampler,
    kind: SamplerKind,
    record: RecordDeclaration,
    sources: list[Source],
    task: TaskDeclaration,
    table: Table,
) -> bool:
    """A pair becomes the record's two fields; of a tower, each thing may be either."""
    span = goal.result.span if goal.result else head(goal.span, goal.name)
    note = Note(f"'{record.name}' is declared here", record.name_span)
    types = [type for type, _ in sources]
    if len(record.fields) != 2:
        message = f"'{goal.name}' fills two fields, and a {record.name} has {len(record.fields)}"
        table.report("E202", message, span, "", note, fix=other_record(goal, kind, types, task, table))
        return False
    wanted = filled(kind, types, record)
    index = next((i for i, (type, field) in enumerate(wanted) if not fits(table, type, field.type)), None)
    if index is None:
        return True
    type, field = wanted[index]
    message = f"'{field.name}' is {phrase(field.type)}, and these are each {phrase(type)}"
    is_clear = len(types) == 1 or not kind.many_sources  # which of the groups is wrong
    others = other_groups(goal, kind, index, record, task, table) if is_clear else []
    if not kind.many_sources and fills(kind, types[::-1], record, table):
        fix = Fix(goal.span, format_sampler(replace(goal, groups=goal.groups[::-1])))
        place = goal.group_spans[0] if goal.group_spans else span
        table.report("E202", message, place, "the other way round they fit", note, fix=fix)
    elif len(others) == 1 and goal.group_spans:
        at = 0 if kind.many_sources else index
        help = f"'{others[0]}' would fit"
        place = goal.group_spans[at]
        table.report("E202", message, place, help, note, fix=Fix(place, others[0]))
    else:
        other = other_record(goal, kind, types, task, table)
        help = f"did you mean {other.replacement}?" if other else ""
        table.report("E202", message, span, help, note, fix=other)
    return False


def _check_options(
    goal: Sampler, kind: SamplerKind, sources: list[Source] | None, table: Table
) -> Mapping[str, Option] | None:
    before = len(table.mistakes)
    for option in goal.options:
        if option.name not in kind.options:
            what = f"'{goal.name}' has no option"
            span = _option_span(option)
            wrong = unknown("E109", what, option.name, span, kind.options)
            if option.name in LENGTHS and kind.length not in {each.name for each in goal.options}:
                help = f"its length is called '{kind.length}'"
                wrong = replace(wrong, help=help, fix=Fix(span, kind.length))
            table.mistakes.append(wrong)
    options = _check_ranges(goal, table)
    missing = [name for name in kind.needed if name not in options]
    if missing and len(table.mistakes) == before:
        message = f"'{goal.name}' needs to be told its {' and '.join(missing)}"
        whole = format_sampler(with_options(goal, kind, [count for _, count in sources or ()]))
        fix = Fix(goal.span, whole)
        table.report("E502", message, head(goal.span, goal.name), f"for example: {whole}", fix=fix)
    return options if len(table.mistakes) == before else None


def _check_ranges(goal: Sampler, table: Table) -> Mapping[str, Option]:
    options: dict[str, Option] = {}
    for option in goal.options:
        if option.name in options:
            message = f"'{option.name}' is set twice"
            help, fix = "one of the two is enough", without(option, goal)
            table.report("E305", message, _option_span(option), help, fix=fix)
        elif option.low > option.high:
            message = f"{option.low}..{option.high} is empty: it ends below its start"
            fix = other_range(option, (option.high, option.low))
            table.report("E502", message, option.span, "the lower number comes first", fix=fix)
        options.setdefault(option.name, option)
    return options


def _option_span(option: Option) -> Span:
    return head(option.span, option.name)
