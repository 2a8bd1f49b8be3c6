"""Repairs of tasks that lack something, by what the rest of the task says."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import permutations

from ntp_dsl.language.diagnostics.diagnostics import Fix
from ntp_dsl.language.logic.facts import substitute
from ntp_dsl.language.names.samplers import SAMPLERS, SamplerKind, blocks_needed
from ntp_dsl.language.names.signatures import fits
from ntp_dsl.language.names.symbol_table import SymbolTable
from ntp_dsl.language.syntax import nodes
from ntp_dsl.language.syntax.formatter import format_expression, format_group, format_sampler
from ntp_dsl.language.syntax.nodes import (
    Option,
    ProgramDeclaration,
    RecordDeclaration,
    Sampler,
    SceneGroup,
    Span,
    TaskDeclaration,
    TypeName,
)
from ntp_dsl.language.syntax.visitors import predicates

ORDER = ("scene", "goal", "run", "success")
DEFAULT_COUNT, DEFAULT_LENGTH = 8, 3  # objects in a scene, and elements of a goal
DEFAULT_HEIGHT = 4


def missing_section(task: TaskDeclaration, section: str, goal: str, table: SymbolTable) -> Fix | None:
    """Write the missing line where it belongs."""
    text = {"scene": _scene, "goal": _goal, "run": _run, "success": _success}[section](task, goal, table)
    if text is None:
        return None
    line = f"{section}:".ljust(9) + text
    before = [span for name in ORDER[: ORDER.index(section)] for span in _spans(task, name)]
    after = [span for name in ORDER for span in _spans(task, name)]
    if before:
        last = max(before, key=lambda span: (span.end_line, span.end_column))
        place = Span(last.path, last.end_line, last.end_column, last.end_line, last.end_column)
        return Fix(place, f"\n    {line}")
    if after:
        first = min(after, key=lambda span: span.line)
        return Fix(Span(first.path, first.line, 1, first.line, 1), f"    {line}\n")
    return None


def _spans(task: TaskDeclaration, section: str) -> list[Span]:
    value = task.shared if section == "scene" and task.shared else getattr(task, section)
    found: Sequence[nodes.Node] = value if isinstance(value, tuple) else [value] if value else []
    return [node.span for node in found]


def _scene(task: TaskDeclaration, goal: str, table: SymbolTable) -> str | None:
    """Write a scene with the usual number of objects of the types that the goal's record takes."""
    sampler = task.sampler
    if sampler is None or not sampler.groups or "table" not in table.constants:
        return None
    record = _record(sampler, table)
    kind = SAMPLERS.get(sampler.name)
    if record is None or kind is None or len(record.fields) != 2:
        return None
    types = [field.type.name for field in record.fields]
    if kind.many_sources:
        narrowest = types[0] if table.is_a(types[0], types[1]) else types[1]
        types = [narrowest] * len(sampler.groups)
    pairs = zip(sampler.groups, types, strict=False)
    groups = [SceneGroup(name, DEFAULT_COUNT, TypeName(type)) for name, type in pairs if type in table.types]
    return ", ".join(map(format_group, groups)) or None


def _record(sampler: Sampler, table: SymbolTable) -> nodes.RecordDeclaration | None:
    kind = SAMPLERS.get(sampler.name)
    name = sampler.result.name if sampler.result else kind.record if kind else ""
    return table.records.get(name)


def _goal(task: TaskDeclaration, goal: str, table: SymbolTable) -> str | None:
    """Write towers of the first group, if the program that runs takes such a list."""
    program = table.programs.get(task.run.callee) if task.run else None
    lists = [each.type.name for each in program.parameters if each.type.is_list] if program else []
    record = table.records.get(lists[0]) if len(lists) == 1 else None
    if record is None or not task.scene or len(record.fields) != 2:
        return None
    name = "towers" if len(task.scene) == 1 else "matchings"
    groups = task.scene[: len(SAMPLERS[name].sources)]
    result = None if record.name == SAMPLERS[name].record else TypeName(record.name, is_list=True)
    sampler = Sampler(name, tuple(each.name for each in groups), (), result)
    return format_sampler(with_options(sampler, SAMPLERS[name], [each.count for each in groups]))


def with_options(sampler: Sampler, kind: SamplerKind, counts: Sequence[int]) -> Sampler:
    """Return the sampler with every option that it needs, set to what the scene allows."""
    height = min(DEFAULT_HEIGHT, max(2, sum(counts)))
    lengths = range(1, DEFAULT_LENGTH + 1)
    most = max((n for n in lengths if blocks_needed(n, min(height, n + 1)) <= sum(counts)), default=1)
    usual: Mapping[str, tuple[int, int]] = {
        "placements": (1, most),
        "height": (2, height),
        "pairs": (1, min(DEFAULT_LENGTH, *counts) if counts else DEFAULT_LENGTH),
    }
    given = {each.name for each in sampler.options}
    more = tuple(Option(name, *usual[name]) for name in kind.needed if name not in given)
    return replace(sampler, options=(*sampler.options, *more))


def _run(task: TaskDeclaration, goal: str, table: SymbolTable) -> str | None:
    """Write a call of the only program that takes such a goal; of several, the one that achieves success."""
    record = _record(task.sampler, table) if task.sampler else None
    if record is None:
        return None
    wanted = TypeName(record.name, is_list=True)
    fitting = [each for each in table.programs.values() if [p.type for p in each.parameters] == [wanted]]
    judged = predicates(task.success)
    exact = [each for each in fitting if predicates(each.achieves) == judged]
    chosen = fitting if len(fitting) == 1 else exact
    return f"{chosen[0].name}({goal})" if len(chosen) == 1 else None


def _success(task: TaskDeclaration, goal: str, table: SymbolTable) -> str | None:
    """Write what the program that runs achieves of its arguments."""
    meant = promised(task, table)
    return format_expression(meant) if meant is not None else None


def promised(task: TaskDeclaration, table: SymbolTable) -> nodes.Expression | None:
    """Return what the program that runs achieves, in the task's terms."""
    program = table.programs.get(task.run.callee) if task.run else None
    if program is None or program.achieves is None or task.run is None:
        return None
    return promise_of_call(program, task.run)


def other_run(task: TaskDeclaration, goal: str, table: SymbolTable) -> Fix | None:
    """Run the program that takes such a goal, in place of another."""
    text = _run(task, goal, table)
    return Fix(task.run.span, text) if task.run is not None and text is not None else None


def typed_goal(task: TaskDeclaration, table: SymbolTable) -> Fix | None:
    """Write `-> list[RECORD]`, of what the program that runs takes, behind a goal without a type."""
    goal, program = task.sampler, table.programs.get(task.run.callee) if task.run else None
    kind = SAMPLERS.get(goal.name) if goal else None
    wanted = [each.type for each in program.parameters if each.type.is_list] if program else []
    if goal is None or goal.result is not None or kind is None or len(wanted) != 1:
        return None
    groups = {each.name: each.type for each in task.scene}
    types = [groups.get(name, TypeName(name)) for name in goal.groups]
    record = table.records.get(wanted[0].name)
    if record is None or record.name == kind.record or not fills(kind, types, record, table):
        return None
    end = goal.span
    place = Span(end.path, end.end_line, end.end_column, end.end_line, end.end_column)
    return Fix(place, f" -> list[{record.name}]")


def promise_of_call(program: ProgramDeclaration, call: nodes.Call) -> nodes.Expression | None:
    """Return what the program achieves, in the terms of one call; None where lists are not named."""
    assert program.achieves is not None
    given = dict(zip([each.name for each in program.parameters], call.arguments, strict=False))
    return _renamed(program.achieves, given)


def _renamed(condition: nodes.Expression, given: Mapping[str, nodes.Expression]) -> nodes.Expression | None:
    match condition:
        case nodes.And(values) | nodes.Or(values):
            parts = [_renamed(each, given) for each in values]
            whole = tuple(each for each in parts if each is not None)
            return replace(condition, values=whole) if len(whole) == len(parts) else None
        case nodes.Not(value):
            inner = _renamed(value, given)
            return nodes.Not(inner) if inner is not None else None
        case nodes.Quantified(_, body, generators):
            inner = _renamed(body, given)
            moved: list[nodes.Generator] = []
            for each in generators:
                domain = given.get(each.iterable.id, each.iterable)
                filter = _renamed(each.condition, given) if each.condition is not None else None
                if not isinstance(domain, nodes.Name):
                    return None
                moved.append(replace(each, iterable=domain, condition=filter))
            return replace(condition, body=inner, generators=tuple(moved)) if inner else None
    return substitute(condition, given)


def other_range(option: Option, better: tuple[int, int] | None) -> Fix | None:
    """Write the option with another range."""
    if better is None:
        return None
    low, high = better
    text = f"{option.name}={low}" + (f"..{high}" if high != low else "")
    return Fix(option.span, text)


def without(option: Option, sampler: Sampler) -> Fix | None:
    """Remove an option from the sampler, and the comma before it."""
    places = [*sampler.group_spans, *(each.span for each in sampler.options)]
    before = [span for span in places if (span.line, span.column) < (option.span.line, option.span.column)]
    if not before:
        return None
    last = before[-1]
    end = option.span
    return Fix(Span(end.path, last.end_line, last.end_column, end.end_line, end.end_column), "")


def with_groups(
    goal: Sampler,
    kind: SamplerKind,
    record: RecordDeclaration | None,
    task: TaskDeclaration,
    table: SymbolTable,
) -> Fix | None:
    """Write the groups of the scene, where it is clear which are meant: those named, and what fits."""
    wanted = len(kind.sources)
    types = {each.name: each.type for each in task.scene}
    types |= {name: TypeName(name) for name in goal.groups if name in table.enums}
    if kind.many_sources:
        fitting = [
            each.name for each in task.scene if record is None or fills(kind, [each.type], record, table)
        ]
        choices = [tuple(fitting)] if fitting else []
    else:
        choices = [
            each
            for each in permutations(types, wanted)
            if set(goal.groups) <= set(each) or set(each) <= set(goal.groups)
            if record is None or fills(kind, [types[name] for name in each], record, table)
        ]
    if len(choices) != 1:
        return None
    return Fix(goal.span, format_sampler(replace(goal, groups=choices[0])))


def filled(
    kind: SamplerKind, types: Sequence[TypeName], record: RecordDeclaration
) -> list[tuple[TypeName, nodes.Parameter]]:
    """Return which type fills which field; of a tower, each object may fill either."""
    first, second = record.fields
    if kind.many_sources:
        return [(type, field) for type in types for field in (first, second)]
    return [*zip(types, (first, second), strict=False)]


def fills(
    kind: SamplerKind, types: Sequence[TypeName], record: RecordDeclaration, table: SymbolTable
) -> bool:
    """Return whether a record can be made of objects of these types."""
    return len(record.fields) == 2 and all(
        fits(table, type, field.type) for type, field in filled(kind, types, record)
    )


def other_groups(
    goal: Sampler,
    kind: SamplerKind,
    index: int,
    record: RecordDeclaration,
    task: TaskDeclaration,
    table: SymbolTable,
) -> list[str]:
    """Return the groups that would fit in place of one that does not."""
    fields = record.fields if kind.many_sources else (record.fields[index],)
    return [
        each.name
        for each in task.scene
        if each.name not in goal.groups and all(fits(table, each.type, field.type) for field in fields)
    ]


def other_record(
    goal: Sampler, kind: SamplerKind, types: Sequence[TypeName], task: TaskDeclaration, table: SymbolTable
) -> Fix | None:
    """Write the list that the program which runs takes, or else the only one that the objects can fill."""
    if goal.result is None:
        return None
    program = table.programs.get(task.run.callee) if task.run else None
    wanted = [each.type.name for each in program.parameters if each.type.is_list] if program else []
    fitting = [each.name for each in table.records.values() if fills(kind, types, each, table)]
    meant = [name for name in fitting if name in wanted] or fitting
    text = meant[0] if len(meant) == 1 else ""
    return Fix(goal.result.span, text if goal.result.is_list else f"list[{text}]") if text else None


def reversed_count(group: SceneGroup) -> Fix | None:
    """Write `3..6` for `6..3`."""
    assert group.most is not None
    swapped = replace(group, count=group.most, most=group.count)
    return Fix(group.span, format_group(swapped))
