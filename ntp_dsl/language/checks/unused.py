"""Checks for what is declared and never used, which is often a sign of another mistake.

A library without tasks is for others: whatever it declares may be used there. A name that begins with `_` is
meant to be unused. Where there are errors, use cannot be told for sure, and only what is seen within one
sound declaration is reported.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence

from ntp_dsl.language.checks.scenes import GOAL, numbered_objects
from ntp_dsl.language.diagnostics.diagnostics import Diagnostic
from ntp_dsl.language.names.references import expressions_of, references, statement_parts
from ntp_dsl.language.names.signatures import leading_span
from ntp_dsl.language.names.symbol_table import KINDS, SymbolTable
from ntp_dsl.language.names.use_statements import line_removal
from ntp_dsl.language.names.visibility import Unit, dependencies, key
from ntp_dsl.language.parsing.partial_library import Key
from ntp_dsl.language.syntax import nodes
from ntp_dsl.language.syntax.nodes import PYTHON, Declaration, Expression, Generator
from ntp_dsl.language.syntax.visitors import walk

References = Callable[[Declaration], frozenset[Key]]


def unused_within(declaration: Declaration) -> Iterator[Diagnostic]:
    """Report parameters and variables that a sound declaration does not use, and a goal that is not run."""
    match declaration:
        case nodes.ProgramDeclaration(by=None):
            parts = expressions_of(declaration)
            yield from _unused_parameters(declaration.parameters, parts)
            yield from _unused_variables(parts)
            for statement in declaration.body:
                yield from _unused_loops(statement)
        case nodes.ApiDeclaration():
            yield from _unused_variables(expressions_of(declaration))
        case nodes.PredicateDeclaration(body=body) if body is not None:
            yield from _unused_parameters(declaration.parameters, [body])
            yield from _unused_variables([body])
        case nodes.TaskDeclaration(goal=goal, run=run) if goal is not None and run is not None:
            if GOAL not in _names(run.arguments):
                what = "drawn" if isinstance(goal, nodes.Sampler) else "given"
                message = f"a goal is {what}, and 'run' does not pass it to '{run.callee}'"
                help = f"for example: run: {run.callee}({GOAL})"
                span = leading_span(goal.span, goal.name) if isinstance(goal, nodes.Sampler) else goal.span
                yield Diagnostic("W105", message, span, help=help)
            yield from _unused_variables([declaration.success])


def _names(parts: Iterable[Expression | Generator | None]) -> set[str]:
    found = (each for part in parts for each in walk(part))
    return {each.id for each in found if isinstance(each, nodes.Name)}


def _unused_parameters(
    parameters: Sequence[nodes.Parameter], parts: Sequence[Expression | Generator | None]
) -> Iterator[Diagnostic]:
    needed = _names(parts)
    for each in parameters:
        if each.name not in needed and not each.name.startswith("_"):
            message = f"the parameter '{each.name}' is not used"
            help = f"remove it, or call it '_{each.name}' if it is needed"
            yield Diagnostic("W102", message, each.span, help=help)


def _unused_variables(parts: Iterable[Expression | Generator | None]) -> Iterator[Diagnostic]:
    for part in parts:
        for each in walk(part):
            if isinstance(each, nodes.Quantified):
                needed = _names([each.body, *each.generators])
                yield from (_unused_variable(g) for g in each.generators if _is_unused(g, needed))


def _unused_loops(statement: nodes.Statement) -> Iterator[Diagnostic]:
    needed = _names(statement_parts(statement))
    while not isinstance(statement, nodes.Call):
        if isinstance(statement, nodes.For) and _is_unused(statement.generator, needed):
            yield _unused_variable(statement.generator)
        statement = statement.body


def _is_unused(generator: Generator, needed: set[str]) -> bool:
    return generator.variable not in needed and not generator.variable.startswith("_")


def _unused_variable(generator: Generator) -> Diagnostic:
    message = f"the variable '{generator.variable}' is not used: every iteration is the same"
    help = f"call it '_{generator.variable}' if that is intended"
    return Diagnostic("W103", message, generator.span, help=help)


def unused_between(
    units: Sequence[Unit], table: SymbolTable, references: References = references
) -> Iterator[Diagnostic]:
    """Report what is used in vain, and what none of the tasks reaches, in a library without errors."""
    home = units[0].library
    if home.declarations:
        yield from _unused_uses(units, table, references)
    tasks = [each for each in home.declarations if isinstance(each, nodes.TaskDeclaration)]
    if not tasks:
        return
    reached = _reached(tasks, table, references)
    ranges = {
        each.iterable.id
        for declaration in reached.values()
        for part in expressions_of(declaration)
        for each in walk(part)
        if isinstance(each, Generator)
    }
    for task in tasks:
        yield from _unused_groups(task, ranges, table)
    yield from _empty_ranges([each for each in home.declarations if key(each) in reached], tasks, table)
    is_python = any(_is_in_python(each) for each in _all(table))
    unused = [each for each in home.declarations if key(each) not in reached]
    for declaration in unused:
        space, name = key(declaration)
        is_seen = is_python and space != "call"  # Python functions can see every other declaration
        others = (each for each in unused if each is not declaration)
        is_for_unused = any(key(declaration) in _resolved(references(each), table) for each in others)
        if not is_seen and not is_for_unused and not name.startswith("_"):
            word = KINDS[type(declaration)].keyword
            code = "N106" if _is_whole(declaration) else "W106"
            message = f"no task of this library uses {word} '{name}', directly or in what it runs"
            help = (
                f"remove it, or use it in what a task runs; if it is for other libraries, call it '_{name}'"
            )
            yield Diagnostic(code, message, declaration.name_span, help=help)


def _empty_ranges(
    declarations: Sequence[Declaration], tasks: Sequence[nodes.TaskDeclaration], table: SymbolTable
) -> Iterator[Diagnostic]:
    """Report loops and quantifiers over types of which no task has an object: they are about nothing."""
    groups = [group.type.name for task in tasks for group in task.scene]
    there = {type_name for each in groups for type_name in table.ancestors(each)}
    constants = {
        type_name for each in table.constants.values() for type_name in table.ancestors(each.type.name)
    }
    for declaration in declarations:
        for part in expressions_of(declaration):
            for each in walk(part):
                if not isinstance(each, Generator):
                    continue
                name = each.iterable.id
                if name in table.types and name not in there | constants and not name.startswith("_"):
                    message = f"no task of this library has an object of type '{name}': this is about nothing"
                    help = f"give an object of a scene that type, or leave out what is said of '{name}'"
                    yield Diagnostic("N107", message, each.span, help=help)


def _is_whole(declaration: Declaration) -> bool:
    """Return whether it is of use by itself: a program can be run, and a composed predicate evaluated,
    though no task does so yet."""
    if isinstance(declaration, nodes.PredicateDeclaration):
        return declaration.body is not None
    return isinstance(declaration, nodes.ProgramDeclaration)


def _unused_uses(units: Sequence[Unit], table: SymbolTable, references: References) -> Iterator[Diagnostic]:
    owners = {
        key(declaration): index
        for index, unit in enumerate(units)
        for declaration in unit.library.declarations
    }
    referenced = set[Key]().union(*map(references, units[0].library.declarations))
    needed = {owners[each] for each in _resolved(referenced, table) if each in owners}
    brings = {index: {index, *dependencies(units, index)} for index in units[0].uses if index is not None}
    for position, (use, index) in enumerate(zip(units[0].library.uses, units[0].uses, strict=True)):
        if index is None or index == 0 or units[0].uses.index(index) < position:
            continue
        others = set[int]().union(*(brings[each] for each in brings if each != index))
        if index not in needed and not (brings[index] - others) & needed:
            message = f"library '{use.library}' is not needed here"
            yield Diagnostic("W101", message, use.span, fix=line_removal(use))


def _resolved(referenced: Iterable[Key], table: SymbolTable) -> Iterator[Key]:
    """Yield the keys, and for a member of an enumeration also the enumeration."""
    for space, name in referenced:
        yield space, name
        if space == "value":
            yield from (("type", enum) for enum in table.enum_of(name))


def _reached(
    tasks: Sequence[Declaration], table: SymbolTable, references: References
) -> dict[Key, Declaration]:
    """Return all that tasks refer to, directly or not."""
    declared = {key(each): each for each in _all(table)}
    reached: dict[Key, Declaration] = {key(task): task for task in tasks}
    waiting = list(tasks)
    while waiting:
        for each in _resolved(references(waiting.pop()), table):
            if each in declared and each not in reached:
                reached[each] = declared[each]
                waiting.append(declared[each])
    return reached


def _all(table: SymbolTable) -> Iterator[Declaration]:
    for dictionary in table.dictionaries():
        yield from (each for each in dictionary.values() if isinstance(each, Declaration))


def _is_in_python(declaration: Declaration) -> bool:
    by = getattr(declaration, "by", None)
    if isinstance(declaration, nodes.TaskDeclaration) and declaration.sampler is not None:
        by = declaration.sampler.by
    return by is not None and by.id == PYTHON


def _unused_groups(task: nodes.TaskDeclaration, ranges: set[str], table: SymbolTable) -> Iterator[Diagnostic]:
    """Report groups that the task does not name, of a type that no loop iterates over."""
    named = {each.place for each in task.scene} | _names(expressions_of(task))
    named |= {*(task.sampler.groups if task.sampler else ())}
    numbered = {each.name: names for each, names in numbered_objects(task)}
    own = {each.name for each in task.shared.own} if task.shared else {each.name for each in task.scene}
    for group in (each for each in task.scene if each.name in own):
        is_met = any(each in ranges for each in table.ancestors(group.type.name))
        names = {group.name, *numbered.get(group.name, ())}
        if not names & named and not is_met and not group.name.startswith("_"):
            message = f"nothing that this task runs can ever use '{group.name}'"
            help = f"name it in a goal, or call it '_{group.name}' if it is only an obstacle"
            yield Diagnostic("N104", message, leading_span(group.span, group.name), help=help)
