"""Who calls whom: recursion makes progress, calls end in apis, and nothing waits in vain."""

from __future__ import annotations

from collections.abc import Iterable

from ntp_dsl.language import syntax
from ntp_dsl.language.names import Table
from ntp_dsl.language.signatures import head
from ntp_dsl.language.syntax import Statement
from ntp_dsl.language.walks import atoms, callees, innermost, loops, mentions, predicates, union


def check_hierarchy(table: Table, own: Iterable[syntax.Declaration]) -> None:
    """Recursion is guarded, calls end in apis, and an api without a promise stands last.

    Args:
        own: whom to judge; all that they call must be in the table.
    """
    judged = list(own)
    _check_compositions(
        table, [each for each in judged if isinstance(each, syntax.PredicateDeclaration)]
    )
    grounded = _grounded(table)
    for program in (each for each in judged if isinstance(each, syntax.ProgramDeclaration)):
        if program.name not in grounded:
            message = f"'{program.name}' never comes to an api: the robot would do nothing"
            table.report("E406", message, program.name_span, "call an api, or a program that does")
        _check_promises(program, table)
        for statement in program.body:
            call = innermost(statement)
            if not _is_guarded(statement, program, table) and _reaches(
                call.callee, program.name, table
            ):
                _unguarded(program, call, table)


def _check_promises(program: syntax.ProgramDeclaration, table: Table) -> None:
    for statement in program.body[:-1]:
        call = innermost(statement)
        api = table.apis.get(call.callee)
        if api is not None and api.achieves is None:
            message = f"'{api.name}' achieves nothing, so what follows it would never be called"
            help = "make it the last call, or say in its declaration what it achieves"
            table.report("E402", message, head(call.span, call.callee), help)


def _is_guarded(statement: Statement, program: syntax.ProgramDeclaration, table: Table) -> bool:
    """`for x in T if r(x, p): call(x)`: each step goes on along r, from the program's p to x."""
    parameters = {each.name for each in program.parameters}
    given = union(map(mentions, innermost(statement).arguments))
    return any(
        loop.iterable.id in table.types
        and loop.variable in given
        and any(
            loop.variable in mentions(atom) and mentions(atom) & parameters
            for atom in atoms(loop.condition)
        )
        for loop in loops(statement)
    )


def _reaches(start: str, goal: str, table: Table) -> bool:
    """Whether calls that no loop guards lead from one program to another."""
    seen, waiting = set(), [start]
    while waiting:
        name = waiting.pop()
        if name == goal:
            return True
        program = table.programs.get(name)
        if name in seen or program is None:
            continue
        seen.add(name)
        waiting += [
            innermost(each).callee for each in program.body if not _is_guarded(each, program, table)
        ]
    return False


def _unguarded(program: syntax.ProgramDeclaration, call: syntax.Call, table: Table) -> None:
    through = "itself" if call.callee == program.name else f"itself again, through '{call.callee}'"
    message = f"'{program.name}' calls {through}, and nothing says that this comes to an end"
    help = "recursion goes along a relation: for b in Object if on(b, item): ..."
    table.report("E404", message, head(call.span, call.callee), help)


def _grounded(table: Table) -> set[str]:
    """Programs from which some chain of calls ends in an api."""
    grounded = set(table.apis)
    while True:
        more = {
            program.name
            for program in table.programs.values()
            if any(callee in grounded for callee in callees(program))
        }
        if more <= grounded:
            return grounded
        grounded |= more


def _check_compositions(table: Table, own: Iterable[syntax.PredicateDeclaration]) -> None:
    """A composed predicate is not made of itself."""
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
            table.report("E407", f"predicate '{name}' is made of itself", span)
