"""Checks of conditions that never or always hold, and of promises that nothing in a body refers to."""

from __future__ import annotations

from collections.abc import Container, Iterable, Iterator, Sequence
from itertools import zip_longest

from ntp_dsl.language.diagnostics.diagnostics import Diagnostic, Fix, Note
from ntp_dsl.language.logic.facts import ANY, EVERY, compare_values, contradicts, facts, implies, value_of
from ntp_dsl.language.logic.preconditions import MAX_DEPTH, Contracts
from ntp_dsl.language.names.signatures import leading_span
from ntp_dsl.language.names.symbol_table import SymbolTable
from ntp_dsl.language.syntax import nodes
from ntp_dsl.language.syntax.formatter import format_expression, format_statement
from ntp_dsl.language.syntax.nodes import Atom, Compare, Expression, ProgramDeclaration, Span, Statement
from ntp_dsl.language.syntax.visitors import conjuncts, free_names, guards, innermost, walk

REFLEXIVE = {"==": True, "<=": True, ">=": True, "!=": False, "<": False, ">": False}
# Irreflexive relations, whatever world decides them.
IRREFLEXIVE = frozenset(
    "on in above below under covers inside contains behind in_front_of left_of right_of".split()
)


def check_conditions(table: SymbolTable, declaration: nodes.Declaration) -> Iterator[Diagnostic]:
    """Check that no condition contradicts itself, compares an object with itself, or puts it on itself."""
    for condition in _conditions(declaration):
        for part in walk(condition):
            yield from _check_part(part, table)


def _conditions(declaration: nodes.Declaration) -> Iterator[Expression]:
    match declaration:
        case nodes.PredicateDeclaration():
            found = [declaration.body]
        case nodes.ApiDeclaration():
            found = [declaration.requires, declaration.achieves]
        case ProgramDeclaration():
            found = [declaration.requires, declaration.achieves]
            written = (each for each in declaration.body if not _is_else(each))
            found += [guard for statement in written for guard in guards(statement)]
        case nodes.TaskDeclaration():
            found = [declaration.success]
        case _:
            return
    yield from (each for each in found if each is not None)


def _check_part(part: Expression | nodes.Generator, table: SymbolTable) -> Iterator[Diagnostic]:
    match part:
        case nodes.And(values):
            yield from _check_conjunction(values, table)
        case Compare():
            yield from _check_comparison(part)
        case Atom(predicate, (one, other)) if one == other and predicate in IRREFLEXIVE:
            declared = table.predicates.get(predicate)
            if declared is not None and declared.body is None and one != ANY:
                what = format_expression(one)
                message = f"'{predicate}' never holds of an object and itself: {what} is given here twice"
                yield Diagnostic("W404", message, part.span)


def _check_conjunction(values: Sequence[Expression], table: SymbolTable) -> Iterator[Diagnostic]:
    for index, value in enumerate(values):
        for other in values[:index]:
            clash = any(contradicts(b, a, table.members) for a in facts(other) for b in facts(value))
            if clash:
                message = f"{format_expression(value)} contradicts an earlier condition"
                note = Note(f"namely {format_expression(other)}", other.span)
                yield Diagnostic("E409", message, value.span, (note,), "remove one of the two")
                break


def _check_comparison(node: Compare) -> Iterator[Diagnostic]:
    left, right = value_of(node.left), value_of(node.right)
    if left is not None and right is not None:
        truth = compare_values(left, node.operator, right)
        message = f"this compares literal numbers: it is always {str(truth).lower()}"
    elif node.left == node.right:
        truth = REFLEXIVE[node.operator]
        message = f"this compares an expression with itself: it is always {str(truth).lower()}"
    else:
        return
    help = "one of the two sides is probably a mistake"
    yield Diagnostic("W401", message, node.span, help=help)


# Programs ----------------------------------------------------------------------------------------


def check_program(contracts: Contracts, program: ProgramDeclaration) -> Iterator[Diagnostic]:
    """Check that a program is not done before it begins, that its conditions can hold, and that it works on
    what it promises."""
    if contracts.has_error(program):
        return
    yield from _check_requirement(program, contracts)
    for statement, after in zip_longest(program.body, program.body[1:]):
        if not _is_else(statement):
            yield from _check_guards(statement, program, contracts, is_alone=not _is_else(after))
        yield from _check_irreflexive(statement, contracts)
    yield from _check_promise(program, contracts)


def _definite_facts(condition: Expression | None) -> list[Expression]:
    """Return the facts about named objects; those about some or every object are left out."""
    return [fact for fact in facts(condition) if not {ANY, EVERY} & set(walk(fact))]


def _follows(condition: Expression | None, known: Sequence[Expression], members: Container[str]) -> bool:
    """Return whether the condition follows from the known facts alone."""
    wanted = list(facts(condition))
    definite = _definite_facts(condition)
    return len(definite) == len(wanted) > 0 and all(
        any(implies(have, fact, members) for have in known) for fact in definite
    )


def _check_requirement(program: ProgramDeclaration, contracts: Contracts) -> Iterator[Diagnostic]:
    if program.requires is not None and _follows(
        program.achieves, _definite_facts(program.requires), contracts.members
    ):
        message = f"'{program.name}' requires what it achieves: it would return before its first call"
        note = Note("required here", program.requires.span)
        yield Diagnostic("W403", message, program.name_span, (note,))


def _is_else(statement: Statement | None) -> bool:
    return isinstance(statement, nodes.When) and statement.is_else


def _check_guards(
    statement: Statement, program: ProgramDeclaration, contracts: Contracts, is_alone: bool
) -> Iterator[Diagnostic]:
    """Check that each condition around a call may hold, and may not.

    Args:
        is_alone: no `else` follows, so that a `when` may be left out.
    """
    members = contracts.members
    known = _definite_facts(program.requires)
    while not isinstance(statement, nodes.Call):
        condition = (
            statement.condition if isinstance(statement, nodes.When) else statement.generator.condition
        )
        stated = _definite_facts(condition)
        if condition is None or contracts.has_error(condition):
            pass
        elif any(contradicts(fact, have, members) for fact in stated for have in known):
            message = "this never holds here: an earlier condition excludes it"
            yield Diagnostic("W402", message, condition.span)
        elif _follows(program.achieves, stated, members):
            message = f"where this holds, '{program.name}' has achieved everything and returned"
            yield Diagnostic("W402", message, condition.span)
        elif _follows(condition, known, members):
            message = "this always holds here: an earlier condition implies it"
            fix = _without_when(statement) if is_alone else None
            yield Diagnostic("W402", message, condition.span, fix=fix)
        known += stated
        statement = statement.body


def _without_when(statement: nodes.When | nodes.For) -> Fix | None:
    """Write the call without its `when`."""
    body = statement.body
    if not isinstance(statement, nodes.When) or not isinstance(body, nodes.Call):
        return None
    start, end = statement.span, body.span
    whole = Span(start.path, start.line, start.column, end.end_line, end.end_column)
    return Fix(whole, format_statement(body)[0])


def _check_irreflexive(statement: Statement, contracts: Contracts) -> Iterator[Diagnostic]:
    call = innermost(statement)
    for fact in contracts.contract(call, "achieves"):
        match fact:
            case Atom(predicate, (one, other)) if one == other and predicate in IRREFLEXIVE:
                if one not in (ANY, EVERY):
                    what = format_expression(fact)
                    message = f"this would achieve {what}, which never holds"
                    yield Diagnostic("W404", message, leading_span(call.span, call.callee))


def _check_promise(program: ProgramDeclaration, contracts: Contracts) -> Iterator[Diagnostic]:
    """Check that each promised object is at least mentioned in the body, or promised by a call."""
    if not program.body or program.achieves is None:
        return
    promised = [fact for each in program.body for fact in contracts.promised(each)]
    referenced = set[str]().union(*map(_referenced, program.body))
    # A held object needs no mention: it is moved with the hand.
    carried = [fact for fact in facts(program.requires) if contracts.achievers(fact)]
    referenced = referenced.union(*map(free_names, carried))
    parameters = {each.name for each in program.parameters}
    for part in conjuncts(program.achieves):
        unpromised = list(_unpromised(facts(part), promised, contracts))
        if not unpromised:
            continue
        unreferenced = sorted(free_names(part) & parameters - referenced)
        about = format_expression(part)
        if unreferenced:
            message = f"{about} is promised, and no call refers to '{unreferenced[0]}'"
        elif (elsewhere := _promised_elsewhere(unpromised, promised)) and not _calls_api(program, contracts):
            message = f"{about} is promised, and the calls achieve '{elsewhere}' of other objects only"
        else:
            continue
        yield Diagnostic("N401", message, part.span)


def _referenced(statement: Statement) -> set[str]:
    names = {name for argument in innermost(statement).arguments for name in free_names(argument)}
    while not isinstance(statement, nodes.Call):
        if isinstance(statement, nodes.For):
            names |= free_names(statement.generator)
        else:
            names |= free_names(statement.condition)
        statement = statement.body
    return names


def _unpromised(
    wanted: Iterable[Expression],
    promised: Sequence[Expression],
    contracts: Contracts,
    depth: int = MAX_DEPTH,
) -> Iterator[Expression]:
    """Yield the facts that no call promises; of a composed predicate, those of its parts.

    A fact that no program or api achieves is taken as given.
    """
    for fact in wanted:
        if not contracts.achievers(fact) or any(implies(have, fact, contracts.members) for have in promised):
            continue
        parts = contracts.parts(fact) if depth else []
        if parts:
            yield from _unpromised(parts, promised, contracts, depth - 1)
        else:
            yield fact


def _promised_elsewhere(unpromised: Sequence[Expression], promised: Sequence[Expression]) -> str:
    """Return a predicate that the calls promise, but of other objects, if there is one."""
    predicates = {fact.predicate for fact in promised if isinstance(fact, Atom)}
    same = (each.predicate for each in unpromised if isinstance(each, Atom) and each.predicate in predicates)
    return next(same, "")


def _calls_api(program: ProgramDeclaration, contracts: Contracts) -> bool:
    """Return whether the program calls an api, which may change more than it promises."""
    return any(innermost(each).callee in contracts.table.apis for each in program.body)
