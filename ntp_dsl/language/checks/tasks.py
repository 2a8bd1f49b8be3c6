"""What a task must say: a scene, a goal that it allows, the program to run, and what success is."""

from __future__ import annotations

from dataclasses import replace

from ntp_dsl.language.checks.goals import check_goal
from ntp_dsl.language.checks.scenes import GOAL, check_scene
from ntp_dsl.language.checks.type_checker import Typing
from ntp_dsl.language.diagnostics.diagnostics import Fix
from ntp_dsl.language.names.signatures import head
from ntp_dsl.language.names.symbol_table import Table
from ntp_dsl.language.repairs.task_repairs import missing_section, other_run, promised, typed_goal
from ntp_dsl.language.syntax.formatter import format_expression
from ntp_dsl.language.syntax.nodes import Atom, Name, Number, TaskDeclaration, TypeName
from ntp_dsl.language.syntax.visitors import mentions

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
            fix = missing_section(task, section, GOAL, table)
            help = f"write it below: {fix.replacement.strip()}" if fix else f"for example: {example}"
            table.report("E501", message, task.name_span, help, fix=fix)
    check_scene(task, table)
    names = {group.name: TypeName(group.type.name, is_list=True) for group in task.scene}
    if task.goal is not None:
        names[GOAL] = TypeName(check_goal(task.goal, task, table), is_list=True)
    before = len(table.mistakes)
    if task.run is not None and task.run.callee in table.apis:
        message = f"'{task.run.callee}' is an api; a task runs a program"
        fix = other_run(task, GOAL, table)
        table.report("E503", message, head(task.run.span, task.run.callee), fix=fix)
    elif task.run is not None:
        typing.call(task.run, names)
        if task.goal is not None and len(table.mistakes) > before:
            _propose(table, before, typed_goal(task, table) or other_run(task, GOAL, table))
            names[GOAL] = TypeName("", is_list=True)  # it may be another goal that is meant
    if task.success is not None:
        ahead = len(table.mistakes)
        typing.condition(task.success, names)
        is_call = isinstance(task.success, Atom) and task.success.predicate in table.programs
        is_none = is_call or isinstance(task.success, Name | Number)  # no condition at all
        if is_none and (meant := promised(task, table)) is not None:
            _propose(table, ahead, Fix(task.success.span, format_expression(meant)))
    if len(table.mistakes) == before:
        _check_judgement(task, table)


def _propose(table: Table, start: int, fix: Fix | None) -> None:
    """The fix for the one mistake that was found from there on, if nothing better is known."""
    if len(table.mistakes) == start + 1 and table.mistakes[start].fix is None and fix is not None:
        help = table.mistakes[start].help or f"did you mean '{fix.replacement.strip()}'?"
        table.mistakes[start] = replace(table.mistakes[start], fix=fix, help=help)


def _check_judgement(task: TaskDeclaration, table: Table) -> None:
    """What is drawn and run is also what is judged."""
    if task.goal is None or task.run is None or task.success is None:
        return
    is_run = any(GOAL in mentions(argument) for argument in task.run.arguments)
    if is_run and GOAL not in mentions(task.success):
        meant = promised(task, table)
        fix = Fix(task.success.span, format_expression(meant)) if meant else None
        message = f"this says nothing of the {GOAL} that is drawn and run"
        help = f"what '{task.run.callee}' achieves is: {fix.replacement}" if fix else ""
        table.report("W501", message, task.success.span, help, fix=fix)
