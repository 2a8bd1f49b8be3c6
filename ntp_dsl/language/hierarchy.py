"""Who calls whom: recursion makes progress, calls end in apis, and nothing waits in vain."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from ntp_dsl.language import syntax
from ntp_dsl.language.names import Table
from ntp_dsl.language.signatures import head
from ntp_dsl.language.syntax import Expression, Name, Statement


def innermost(statement: Statement) -> syntax.Call:
    """The call inside all loops and conditions."""
    while not isinstance(statement, syntax.Call):
        statement = statement.body
    return statement


def callees(program: syntax.ProgramDeclaration) -> tuple[str, ...]:
    """What a program may call, each once: by its body, or as it says of its expert in Python."""
    named = [innermost(statement).callee for statement in program.body]
    return tuple(dict.fromkeys([*named, *(each.id for each in program.calls)]))


def loops(statement: Statement) -> Iterator[syntax.Generator]:
    """The generators around a statement's call, from the outside in."""
    while not isinstance(statement, syntax.Call):
        if isinstance(statement, syntax.For):
            yield statement.generator
        statement = statement.body


def mentions(expression: Expression | None) -> set[str]:
    """Every name that occurs in an expression."""
    match expression:
        case Name(id):
            return {id}
        case syntax.Field(value, _):
            return {value.id}
        case syntax.Atom(_, parts) | syntax.And(parts) | syntax.Or(parts):
            return _union(parts)
        case syntax.Arithmetic(_, left, right) | syntax.Compare(_, left, right):
            return mentions(left) | mentions(right)
        case syntax.Not(value):
            return mentions(value)
        case syntax.Quantified(_, body, generators):
            inner = mentions(body) | _union(
                each.condition for each in generators if each.condition is not None
            )
            return inner - {each.variable for each in generators} | {
                each.iterable.id for each in generators
            }
    return set()


def _union(parts: Iterable[Expression]) -> set[str]:
    return {name for part in parts for name in mentions(part)}


def check_hierarchy(table: Table) -> None:
    """Recursion is guarded, calls end in apis, and an api without a promise stands last."""
    _check_compositions(table)
    grounded = _grounded(table)
    for program in table.programs.values():
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
    given = _union(innermost(statement).arguments)
    return any(
        loop.iterable.id in table.types
        and loop.variable in given
        and any(
            loop.variable in mentions(atom) and mentions(atom) & parameters
            for atom in _atoms(loop.condition)
        )
        for loop in loops(statement)
    )


def _atoms(condition: Expression | None) -> Iterator[syntax.Atom]:
    if isinstance(condition, syntax.Atom):
        yield condition
    elif isinstance(condition, syntax.And):
        for value in condition.values:
            yield from _atoms(value)


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


def _check_compositions(table: Table) -> None:
    """A composed predicate is not made of itself."""
    parts = {each.name: _predicates(each.body) for each in table.predicates.values()}
    for name in parts:
        seen: set[str] = set()
        waiting = set(parts[name])
        while waiting:
            part = waiting.pop()
            seen.add(part)
            waiting |= parts.get(part, set()) - seen
        if name in seen:
            span = table.predicates[name].name_span
            table.report("E407", f"predicate '{name}' is made of itself", span)


def _predicates(expression: Expression | syntax.Generator | None) -> set[str]:
    """Every predicate that an expression applies."""
    match expression:
        case syntax.Atom(predicate, parts):
            return {predicate}.union(*map(_predicates, parts))
        case syntax.And(parts) | syntax.Or(parts):
            return set[str]().union(*map(_predicates, parts))
        case syntax.Arithmetic(_, left, right) | syntax.Compare(_, left, right):
            return _predicates(left) | _predicates(right)
        case syntax.Not(value):
            return _predicates(value)
        case syntax.Quantified(_, body, generators):
            return _predicates(body).union(*map(_predicates, generators))
        case syntax.Generator(_, _, condition):
            return _predicates(condition)
    return set()
