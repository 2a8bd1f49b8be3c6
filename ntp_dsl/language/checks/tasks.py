"""Checks of a task: a scene, a goal that it allows, the program to run, and what success is."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from ntp_dsl.language.checks.given import check_given_goal, check_initially
from ntp_dsl.language.checks.goals import check_goal
from ntp_dsl.language.checks.scenes import GOAL, check_scene, named_objects
from ntp_dsl.language.checks.type_checker import TypeChecker
from ntp_dsl.language.diagnostics.diagnostics import Diagnostic, Fix
from ntp_dsl.language.names.signatures import Names, leading_span
from ntp_dsl.language.names.symbol_table import SymbolTable
from ntp_dsl.language.repairs.task_repairs import missing_section, other_run, promised, typed_goal
from ntp_dsl.language.syntax.formatter import format_expression
from ntp_dsl.language.syntax.nodes import Atom, GivenGoal, Name, Number, TaskDeclaration, TypeName
from ntp_dsl.language.syntax.visitors import free_names

SECTIONS = {
    "scene": "scene: blocks: 8 Block on table",
    "goal": "goal: towers(blocks, placements=1..6, height=2..4)",
    "run": "run: stack(goal)",
    "success": "success: all on(p.item, p.support) for p in goal",
}


def check_task(task: TaskDeclaration, table: SymbolTable, typing: TypeChecker) -> Iterator[Diagnostic]:
    """Check that every section is there, names what exists, and can be met."""
    for section, example in SECTIONS.items():
        if not getattr(task, section) and (section != "goal" or _names_goal(task)):
            message = f"task '{task.name}' has no '{section}'"
            fix = missing_section(task, section, GOAL, table)
            help = f"write it below: {fix.replacement.strip()}" if fix else f"for example: {example}"
            yield Diagnostic("E501", message, task.name_span, help=help, fix=fix)
    yield from check_scene(task, table)
    yield from check_initially(task, table, typing)
    names = {group.name: TypeName(group.type.name, is_list=True) for group in task.scene}
    names |= named_objects(task)
    if isinstance(task.goal, GivenGoal):
        names[GOAL] = TypeName((yield from check_given_goal(task.goal, task, table, typing)), is_list=True)
    elif task.goal is not None:
        drawn = yield from check_goal(task.goal, task, table)
        names[GOAL] = TypeName(drawn, is_list=True)
    found: list[Diagnostic] = []
    if task.run is not None and task.run.callee in table.apis:
        message = f"'{task.run.callee}' is an api; a task runs a program"
        fix = other_run(task, GOAL, table)
        found = [Diagnostic("E503", message, leading_span(task.run.span, task.run.callee), fix=fix)]
    elif task.run is not None:
        found = [*typing.call(task.run, names)]
        if found and task.goal is not None:
            found = _propose(found, typed_goal(task, table) or other_run(task, GOAL, table))
            names[GOAL] = TypeName("", is_list=True)  # another goal may be meant
    found += _check_success(task, names, table, typing)
    yield from found or _check_goal_is_judged(task, table)


def _names_goal(task: TaskDeclaration) -> bool:
    """Return whether a goal is needed: where nothing is run, or what is run or judged names it."""
    parts = [*(task.run.arguments if task.run else ()), *([task.success] if task.success else [])]
    return task.run is None or any(GOAL in free_names(part) for part in parts)


def _check_success(
    task: TaskDeclaration, names: Names, table: SymbolTable, typing: TypeChecker
) -> list[Diagnostic]:
    if task.success is None:
        return []
    found = [*typing.condition(task.success, names)]
    is_call = isinstance(task.success, Atom) and task.success.predicate in table.programs
    is_no_condition = is_call or isinstance(task.success, Name | Number)
    if is_no_condition and (meant := promised(task, table)) is not None:
        return _propose(found, Fix(task.success.span, format_expression(meant)))
    return found


def _propose(found: list[Diagnostic], fix: Fix | None) -> list[Diagnostic]:
    """Add the fix where there is one diagnostic without a fix."""
    if len(found) != 1 or found[0].fix is not None or fix is None:
        return found
    help = found[0].help or f"did you mean '{fix.replacement.strip()}'?"
    return [replace(found[0], fix=fix, help=help)]


def _check_goal_is_judged(task: TaskDeclaration, table: SymbolTable) -> Iterator[Diagnostic]:
    """Check that success refers to the goal that is run, or to the objects of a given one."""
    if task.goal is None or task.run is None or task.success is None:
        return
    is_run = any(GOAL in free_names(argument) for argument in task.run.arguments)
    if isinstance(task.goal, GivenGoal):
        judged = free_names(task.success)
        is_run = is_run and not all(free_names(row.terms[0]) <= judged for row in task.goal.rows)
    if is_run and GOAL not in free_names(task.success):
        meant = promised(task, table)
        fix = Fix(task.success.span, format_expression(meant)) if meant else None
        message = f"this does not refer to the {GOAL} that is run"
        help = f"what '{task.run.callee}' achieves is: {fix.replacement}" if fix else ""
        yield Diagnostic("W501", message, task.success.span, help=help, fix=fix)
