"""Checks of who calls whom: recursion makes progress, calls end in apis, and every call is reached."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence

from ntp_dsl.language.diagnostics.diagnostics import Diagnostic, Fix, Note
from ntp_dsl.language.names.signatures import leading_span
from ntp_dsl.language.names.symbol_table import SymbolTable
from ntp_dsl.language.repairs.contract_repairs import reorder
from ntp_dsl.language.syntax import nodes
from ntp_dsl.language.syntax.nodes import Expression, Name, ProgramDeclaration, Statement
from ntp_dsl.language.syntax.visitors import atoms, callees, free_names, innermost, loops, predicates, union

# Names of symmetric relations, along which recursion would go back and forth.
MUTUAL = frozenset(
    "adjacent adjacent_to aligned aligned_with beside close close_to connected equal facing linked near"
    " near_to nearby next_to same same_as similar touches touching".split()
)


def check_hierarchy(table: SymbolTable, own: Sequence[nodes.Declaration]) -> Iterator[Diagnostic]:
    """Check that compositions are made of other predicates, and that chains of calls end in apis.

    Args:
        own: the declarations to check.
    """
    composed = [each for each in own if isinstance(each, nodes.PredicateDeclaration)]
    yield from _check_compositions(table, composed)
    grounded = _grounded(table)
    for program in (each for each in own if isinstance(each, ProgramDeclaration)):
        if program.name not in grounded:
            message = f"'{program.name}' never reaches an api: the robot would do nothing"
            help = "call an api, or a program that does"
            yield Diagnostic("E406", message, program.name_span, help=help)


def check_calls(program: ProgramDeclaration, table: SymbolTable) -> Iterator[Diagnostic]:
    """Check that recursion is guarded, and that an api without a promise comes last."""
    yield from _check_promises(program, table)
    for statement in program.body:
        yield from _check_recursion(statement, program, table)


def _check_promises(program: ProgramDeclaration, table: SymbolTable) -> Iterator[Diagnostic]:
    for index, statement in enumerate(program.body[:-1]):
        call = innermost(statement)
        api = table.apis.get(call.callee)
        if api is not None and api.achieves is None:
            message = f"'{api.name}' achieves nothing, so what follows it would never be called"
            help = "make it the last call, or declare what it achieves"
            note = Note(f"'{api.name}' is declared here", api.name_span)
            order = (*program.body[:index], *program.body[index + 1 :], statement)
            fix = reorder(program.body, order)
            yield Diagnostic("E402", message, leading_span(call.span, call.callee), (note,), help, fix)


# Recursion ---------------------------------------------------------------------------------------


def _check_recursion(
    statement: Statement, program: ProgramDeclaration, table: SymbolTable
) -> Iterator[Diagnostic]:
    call = innermost(statement)
    if not _is_guarded(statement, program, table):
        if _reaches(call.callee, program.name, table):
            yield _unguarded(statement, program, table)
        return
    mutual = [atom for atom in _relations(statement, program, table) if atom.predicate in MUTUAL]
    if mutual and call.callee == program.name:
        name = mutual[0].predicate
        message = f"'{name}' seems to be symmetric: the recursion would go back and forth along it"
        help = "recursion needs a relation without cycles, such as on(b, item)"
        note = Note(f"'{name}' is declared here", table.predicates[name].name_span)
        yield Diagnostic("W405", message, leading_span(call.span, call.callee), (note,), help)


def _is_guarded(statement: Statement, program: ProgramDeclaration, table: SymbolTable) -> bool:
    """Recognise `for x in T if r(x, p): call(x)`: each step goes along r, from the program's p to x."""
    given = union(map(free_names, innermost(statement).arguments))
    return any(
        free_names(atom) & {loop.variable for loop in loops(statement)} & given
        for atom in _relations(statement, program, table)
    )


def _relations(statement: Statement, program: ProgramDeclaration, table: SymbolTable) -> list[nodes.Atom]:
    """Return the relations by which loops over the scene tie their variable to the program's parameters."""
    parameters = {each.name for each in program.parameters}
    return [
        atom
        for loop in loops(statement)
        if loop.iterable.id in table.types
        for atom in atoms(loop.condition)
        if loop.variable in free_names(atom) and free_names(atom) & parameters
    ]


def _reaches(start: str, goal: str, table: SymbolTable) -> bool:
    """Return whether calls that no loop guards lead from one program to another."""
    seen, waiting = set(), [start]
    while waiting:
        name = waiting.pop()
        if name == goal:
            return True
        program = table.programs.get(name)
        if name in seen or program is None:
            continue
        seen.add(name)
        waiting += [innermost(each).callee for each in program.body if not _is_guarded(each, program, table)]
    return False


def _unguarded(statement: Statement, program: ProgramDeclaration, table: SymbolTable) -> Diagnostic:
    call = innermost(statement)
    through = "itself" if call.callee == program.name else f"itself again, through '{call.callee}'"
    message = f"'{program.name}' calls {through}, and nothing guarantees that this ends"
    help = "recursion goes along a relation: for b in Object if on(b, item): ..."
    fix = _step(statement, program, table)
    if fix is not None:
        help = f"pass '{fix.replacement}' on, so that each call takes a step"
    return Diagnostic("E404", message, leading_span(call.span, call.callee), help=help, fix=fix)


def _step(statement: Statement, program: ProgramDeclaration, table: SymbolTable) -> Fix | None:
    """Correct `for b in T if on(b, x): go(x)`, where go(b) is meant."""
    call = innermost(statement)
    for atom in _relations(statement, program, table):
        related = free_names(atom)
        variables = {loop.variable for loop in loops(statement)} & related
        stuck = [each for each in call.arguments if _is_named(each, related - variables)]
        if len(stuck) == 1 and len(variables) == 1:
            return Fix(stuck[0].span, variables.pop())
    return None


def _is_named(argument: Expression, names: set[str]) -> bool:
    return isinstance(argument, Name) and argument.id in names


# Which programs reach an api ---------------------------------------------------------------------


def _grounded(table: SymbolTable) -> set[str]:
    """Return the programs from which some chain of calls ends in an api, or in an error."""
    callers: dict[str, list[str]] = {}
    waiting = list(table.apis)
    for program in table.programs.values():
        named = callees(program)
        for name in named:
            callers.setdefault(name, []).append(program.name)
        if not named or any(table.callable(name) is None for name in named):
            waiting.append(program.name)
    grounded = set(waiting)
    while waiting:
        more = set(callers.get(waiting.pop(), ())) - grounded
        grounded |= more
        waiting += more
    return grounded


def _check_compositions(
    table: SymbolTable, own: Iterable[nodes.PredicateDeclaration]
) -> Iterator[Diagnostic]:
    """Check that no composed predicate is defined by itself."""
    parts = {each.name: predicates(each.body) for each in table.predicates.values()}
    for name in (each.name for each in own):
        seen: set[str] = set()
        waiting = set(parts[name])
        while waiting:
            part = waiting.pop()
            seen.add(part)
            waiting |= parts.get(part, set()) - seen
        if name in seen:
            span = table.predicates[name].name_span
            help = "define it by other predicates, or leave it to the world, without a body"
            yield Diagnostic("E407", f"predicate '{name}' is defined by itself", span, help=help)
