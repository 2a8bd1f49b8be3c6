"""What is declared and never needed: nothing is wrong with it, but perhaps something else is.

A library without tasks is for others: whatever it declares may be needed there. What begins with `_` is meant
to be unused. Where there are errors, what is needed cannot be told for sure, and only what is seen in one
sound declaration is said.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence

from ntp_dsl.language.checks.scenes import GOAL
from ntp_dsl.language.diagnostics.diagnostics import Diagnostic
from ntp_dsl.language.names.references import inside, mentions, said
from ntp_dsl.language.names.signatures import head
from ntp_dsl.language.names.symbol_table import SPACES, Table
from ntp_dsl.language.names.use_statements import removal
from ntp_dsl.language.names.visibility import Unit, below, key
from ntp_dsl.language.parsing.partial_library import Key
from ntp_dsl.language.syntax import nodes
from ntp_dsl.language.syntax.nodes import PYTHON, Declaration, Expression, Generator
from ntp_dsl.language.syntax.visitors import everything

Mentions = Callable[[Declaration], frozenset[Key]]


def unused_within(declaration: Declaration) -> Iterator[Diagnostic]:
    """Parameters and variables that nothing in a sound declaration speaks of; a goal nobody takes."""
    match declaration:
        case nodes.ProgramDeclaration(by=None):
            parts = said(declaration)
            yield from _unused_parameters(declaration.parameters, parts)
            yield from _unused_variables(parts)
            for statement in declaration.body:
                yield from _unused_loops(statement)
        case nodes.ApiDeclaration():
            yield from _unused_variables(said(declaration))
        case nodes.PredicateDeclaration(body=body) if body is not None:
            yield from _unused_parameters(declaration.parameters, [body])
            yield from _unused_variables([body])
        case nodes.TaskDeclaration(goal=goal, run=run) if goal is not None and run is not None:
            if GOAL not in _names(run.arguments):
                message = f"a goal is drawn, and '{run.callee}' is not told: 'run' does not take it"
                help = f"for example: run: {run.callee}({GOAL})"
                yield Diagnostic("W105", message, head(goal.span, goal.name), help=help)
            yield from _unused_variables([declaration.success])


def _names(parts: Iterable[Expression | Generator | None]) -> set[str]:
    found = (each for part in parts for each in everything(part))
    return {each.id for each in found if isinstance(each, nodes.Name)}


def _unused_parameters(
    parameters: Sequence[nodes.Parameter], parts: Sequence[Expression | Generator | None]
) -> Iterator[Diagnostic]:
    needed = _names(parts)
    for each in parameters:
        if each.name not in needed and not each.name.startswith("_"):
            message = f"nothing here speaks of the parameter '{each.name}'"
            help = f"leave it out, or call it '_{each.name}' if it must be there"
            yield Diagnostic("W102", message, each.span, help=help)


def _unused_variables(parts: Iterable[Expression | Generator | None]) -> Iterator[Diagnostic]:
    for part in parts:
        for each in everything(part):
            if isinstance(each, nodes.Quantified):
                needed = _names([each.body, *each.generators])
                yield from (_unused_variable(g) for g in each.generators if _is_idle(g, needed))


def _unused_loops(statement: nodes.Statement) -> Iterator[Diagnostic]:
    needed = _names(inside(statement))
    while not isinstance(statement, nodes.Call):
        if isinstance(statement, nodes.For) and _is_idle(statement.generator, needed):
            yield _unused_variable(statement.generator)
        statement = statement.body


def _is_idle(generator: Generator, needed: set[str]) -> bool:
    return generator.variable not in needed and not generator.variable.startswith("_")


def _unused_variable(generator: Generator) -> Diagnostic:
    message = f"nothing speaks of '{generator.variable}': every round of the loop is the same"
    help = f"call it '_{generator.variable}' if so it is meant"
    return Diagnostic("W103", message, generator.span, help=help)


def unused_between(
    units: Sequence[Unit], table: Table, mentions: Mentions = mentions
) -> Iterator[Diagnostic]:
    """Of a library without errors: what it uses in vain, and what none of its tasks comes to."""
    home = units[0].draft
    if home.declarations:
        yield from _unused_uses(units, table, mentions)
    tasks = [each for each in home.declarations if isinstance(each, nodes.TaskDeclaration)]
    if not tasks:
        return
    reached = _reached(tasks, table, mentions)
    ranges = {
        each.iterable.id
        for declaration in reached.values()
        for part in said(declaration)
        for each in everything(part)
        if isinstance(each, Generator)
    }
    for task in tasks:
        yield from _unused_groups(task, ranges, table)
    in_python = any(_is_in_python(each) for each in _all(table))
    idle = [each for each in home.declarations if key(each) not in reached]
    for declaration in idle:
        space, name = key(declaration)
        is_seen = in_python and space != "call"  # whatever is declared can be seen from Python
        others = (each for each in idle if each is not declaration)
        is_for_idle = any(key(declaration) in _resolved(mentions(each), table) for each in others)
        if not is_seen and not is_for_idle and not name.startswith("_"):
            word = SPACES[type(declaration)][2]
            code = "N106" if _is_whole(declaration) else "W106"
            message = f"none of the tasks comes to {word} '{name}'"
            help = f"leave it out, or call it '_{name}' if it is for others"
            yield Diagnostic(code, message, declaration.name_span, help=help)


def _is_whole(declaration: Declaration) -> bool:
    """A program can be run, and a composed predicate asked for, though no task does so yet; a word that
    nothing speaks of serves nobody."""
    if isinstance(declaration, nodes.PredicateDeclaration):
        return declaration.body is not None
    return isinstance(declaration, nodes.ProgramDeclaration)


def _unused_uses(units: Sequence[Unit], table: Table, mentions: Mentions) -> Iterator[Diagnostic]:
    owners = {
        key(declaration): index for index, unit in enumerate(units) for declaration in unit.draft.declarations
    }
    spoken = set[Key]().union(*map(mentions, units[0].draft.declarations))
    needed = {owners[each] for each in _resolved(spoken, table) if each in owners}
    brings = {index: {index, *below(units, index)} for index in units[0].uses if index is not None}
    for position, (use, index) in enumerate(zip(units[0].draft.uses, units[0].uses, strict=True)):
        if index is None or index == 0 or units[0].uses.index(index) < position:
            continue
        others = set[int]().union(*(brings[each] for each in brings if each != index))
        if index not in needed and not (brings[index] - others) & needed:
            message = f"nothing of library '{use.library}' is needed here"
            yield Diagnostic("W101", message, use.span, fix=removal(use))


def _resolved(spoken: Iterable[Key], table: Table) -> Iterator[Key]:
    """What the names stand for: a member of an enumeration for the enumeration."""
    for space, name in spoken:
        yield space, name
        if space == "value":
            yield from (("type", enum) for enum in table.enum_of(name))


def _reached(tasks: Sequence[Declaration], table: Table, mentions: Mentions) -> dict[Key, Declaration]:
    """All that tasks speak of, and what that speaks of."""
    declared = {key(each): each for each in _all(table)}
    reached: dict[Key, Declaration] = {key(task): task for task in tasks}
    waiting = list(tasks)
    while waiting:
        for each in _resolved(mentions(waiting.pop()), table):
            if each in declared and each not in reached:
                reached[each] = declared[each]
                waiting.append(declared[each])
    return reached


def _all(table: Table) -> Iterator[Declaration]:
    for dictionary in table.dictionaries():
        yield from (each for each in dictionary.values() if isinstance(each, Declaration))


def _is_in_python(declaration: Declaration) -> bool:
    by = getattr(declaration, "by", None)
    if isinstance(declaration, nodes.TaskDeclaration) and declaration.goal is not None:
        by = declaration.goal.by
    return by is not None and by.id == PYTHON


def _unused_groups(task: nodes.TaskDeclaration, ranges: set[str], table: Table) -> Iterator[Diagnostic]:
    """Groups that the task does not name, of a type that no loop goes through."""
    run = task.run.arguments if task.run else ()
    named = {each.place for each in task.scene} | _names([*run, task.success])
    named |= {*(task.goal.groups if task.goal else ())}
    for group in task.scene:
        is_met = any(each in ranges for each in table.ancestors(group.type.name))
        if group.name not in named and not is_met and not group.name.startswith("_"):
            message = f"nothing that this task runs can ever come to '{group.name}'"
            help = f"draw goals from it, or call it '_{group.name}' if it only stands in the way"
            yield Diagnostic("N104", message, head(group.span, group.name), help=help)
