"""What a task must say: a scene, a goal that it allows, the program to run, and what success is."""

from __future__ import annotations

from ntp_dsl.language.diagnostics import unknown
from ntp_dsl.language.names import Table
from ntp_dsl.language.samplers import SAMPLERS, SamplerKind
from ntp_dsl.language.signatures import head, tail
from ntp_dsl.language.syntax import Option, Sampler, SceneGroup, TaskDeclaration, TypeName
from ntp_dsl.language.typing_rules import Typing

GOAL = "goal"  # what `run` and `success` call the list that the sampler draws
SECTIONS = {
    "scene": "scene: blocks: 8 Block on table",
    "goal": "goal: towers(blocks, placements=1..6, height=2..4)",
    "run": "run: stack(goal)",
    "success": "success: all on(p.item, p.support) for p in goal",
}


def check_task(task: TaskDeclaration, table: Table, typing: Typing) -> None:
    """Every section is there, names what exists, and can be met."""
    for section, example in SECTIONS.items():
        if not getattr(task, section):
            message = f"task '{task.name}' has no '{section}'"
            table.report("E501", message, task.name_span, f"for example: {example}")
    for index, group in enumerate(task.scene):
        _check_group(group, task.scene[:index], table)
    names = {group.name: TypeName(group.type.name, is_list=True) for group in task.scene}
    if task.goal is not None:
        kind = _check_goal(task.goal, task, table)
        names[GOAL] = TypeName(kind.record if kind else "", is_list=True)
    if task.run is not None:
        typing.call(task.run, names)
        if task.run.callee in table.apis:
            message = f"'{task.run.callee}' is an api; a task runs a program"
            table.report("E503", message, head(task.run.span, task.run.callee))
    if task.success is not None:
        typing.condition(task.success, names)


def _check_group(group: SceneGroup, before: tuple[SceneGroup, ...], table: Table) -> None:
    if group.type.name not in table.types or group.type.is_list:
        table.mistakes.append(
            unknown("E103", "there is no type", group.type.name, group.type.span, table.types)
        )
    if group.count < 1:
        table.report("E502", f"a scene of no {group.type.name} leaves nothing to do", group.span)
    if group.name in {other.name for other in before} or group.name in table.constants:
        table.report(
            "E305", f"'{group.name}' is in the scene already", head(group.span, group.name)
        )
    places = [*table.constants, *(other.name for other in before)]
    if group.place not in places:
        span = tail(group.span, group.place)
        table.mistakes.append(unknown("E101", "there is no place", group.place, span, places))


def _check_goal(goal: Sampler, task: TaskDeclaration, table: Table) -> SamplerKind | None:
    kind = SAMPLERS.get(goal.name)
    if kind is None:
        span = head(goal.span, goal.name)
        table.mistakes.append(unknown("E108", "there is no sampler", goal.name, span, SAMPLERS))
        return None
    if kind.record not in table.records:
        message = f"'{goal.name}' draws a list of {kind.record}, and no such record is declared"
        table.report("E108", message, head(goal.span, goal.name), "write 'use tabletop' above")
        return None
    groups = _check_groups(goal, task, table)
    options = _check_options(goal, kind, table)
    if groups is not None and options is not None:
        count = sum(group.count for group in groups)
        for name, message in kind.flaws(options, count):
            table.report("E502", message, options[name].span)
    return kind


def _check_groups(goal: Sampler, task: TaskDeclaration, table: Table) -> list[SceneGroup] | None:
    declared = {group.name: group for group in task.scene}
    if not goal.groups:
        message = f"'{goal.name}' is to draw from the scene; name the groups that it may use"
        table.report("E502", message, head(goal.span, goal.name))
        return None
    missing = False
    for index, name in enumerate(goal.groups):
        if name not in declared:
            span = goal.group_spans[index] if goal.group_spans else goal.span
            table.mistakes.append(unknown("E106", "the scene has no group", name, span, declared))
            missing = True
    return None if missing else [declared[name] for name in dict.fromkeys(goal.groups)]


def _check_options(goal: Sampler, kind: SamplerKind, table: Table) -> dict[str, Option] | None:
    before = len(table.mistakes)
    options: dict[str, Option] = {}
    for option in goal.options:
        span = head(option.span, option.name)
        if option.name not in kind.options:
            what = f"'{goal.name}' has no option"
            table.mistakes.append(unknown("E109", what, option.name, span, kind.options))
        elif option.name in options:
            table.report("E305", f"'{option.name}' is set twice", span)
        elif option.low > option.high:
            message = f"{option.low}..{option.high} is empty: it ends below its start"
            table.report("E502", message, option.span)
        options.setdefault(option.name, option)
    missing = [name for name in kind.options if name not in options]
    if missing and len(table.mistakes) == before:
        message = f"'{goal.name}' needs to be told its {' and '.join(missing)}"
        help = f"for example: {SECTIONS['goal']}" if goal.name == "towers" else ""
        table.report("E502", message, head(goal.span, goal.name), help)
    return options if len(table.mistakes) == before else None
