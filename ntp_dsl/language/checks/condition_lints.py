"""Conditions that can never hold, or always do, and promises that nothing in a body speaks of."""

from __future__ import annotations

from collections.abc import Container, Iterable, Iterator, Sequence

from ntp_dsl.language.diagnostics.diagnostics import Diagnostic, Fix, Note
from ntp_dsl.language.logic.facts import ANY, EVERY, compare_values, contradicts, facts, implies, value_of
from ntp_dsl.language.logic.preconditions import DEEPEST, Contracts
from ntp_dsl.language.names.signatures import head
from ntp_dsl.language.names.symbol_table import SymbolTable
from ntp_dsl.language.syntax import nodes
from ntp_dsl.language.syntax.formatter import format_expression, format_statement
from ntp_dsl.language.syntax.nodes import Atom, Compare, Expression, ProgramDeclaration, Span, Statement
from ntp_dsl.language.syntax.visitors import conjuncts, everything, guards, innermost, mentions

REFLEXIVE = {"==": True, "<=": True, ">=": True, "!=": False, "<": False, ">": False}
# What nothing is to itself, whatever world decides it.
IRREFLEXIVE = frozenset(
    "on in above below under covers inside contains behind in_front_of left_of right_of".split()
)


def check_conditions(table: SymbolTable, declaration: nodes.Declaration) -> Iterator[Diagnostic]:
    """Check that no condition denies itself, compares an object with itself, or puts it on itself."""
    for condition in _conditions(declaration):
        for part in everything(condition):
            yield from _check_part(part, table)


def _conditions(declaration: nodes.Declaration) -> Iterator[Expression]:
    match declaration:
        case nodes.PredicateDeclaration():
            found = [declaration.body]
        case nodes.ApiDeclaration():
            found = [declaration.requires, declaration.achieves]
        case ProgramDeclaration():
            found = [declaration.requires, declaration.achieves]
            found += [guard for statement in declaration.body for guard in guards(statement)]
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
                message = f"nothing is {predicate.replace('_', ' ')} itself: {what} stands here twice"
                yield Diagnostic("W404", message, part.span)


def _check_conjunction(values: Sequence[Expression], table: SymbolTable) -> Iterator[Diagnostic]:
    for index, value in enumerate(values):
        for other in values[:index]:
            clash = any(contradicts(b, a, table.members) for a in facts(other) for b in facts(value))
            if clash:
                message = f"{format_expression(value)} can never hold together with what is said before"
                note = Note(f"namely {format_expression(other)}", other.span)
                yield Diagnostic("E409", message, value.span, (note,), "remove one of the two")
                break


def _check_comparison(node: Compare) -> Iterator[Diagnostic]:
    left, right = value_of(node.left), value_of(node.right)
    if left is not None and right is not None:
        truth = compare_values(left, node.operator, right)
        message = f"this compares numbers that are written out: it is always {str(truth).lower()}"
    elif node.left == node.right:
        truth = REFLEXIVE[node.operator]
        message = f"this compares a thing with itself: it is always {str(truth).lower()}"
    else:
        return
    help = "one of the two sides was probably meant otherwise"
    yield Diagnostic("W401", message, node.span, help=help)


# Programs ----------------------------------------------------------------------------------------


def check_program(contracts: Contracts, program: ProgramDeclaration) -> Iterator[Diagnostic]:
    """Check that a program is not done before it begins, waits for nothing that cannot be, and works on
    what it promises."""
    if contracts.is_faulty(program):
        return
    yield from _check_need(program, contracts)
    for statement in program.body:
        yield from _check_guards(statement, program, contracts)
        yield from _check_itself(statement, contracts)
    yield from _check_promise(program, contracts)


def _plain(condition: Expression | None) -> list[Expression]:
    """The facts about things that are named; what is said of some or of every one is left out."""
    return [fact for fact in facts(condition) if not {ANY, EVERY} & set(everything(fact))]


def _follows(condition: Expression | None, known: Sequence[Expression], members: Container[str]) -> bool:
    """Whether the condition is nothing but what is known."""
    wanted = list(facts(condition))
    plain = _plain(condition)
    return len(plain) == len(wanted) > 0 and all(
        any(implies(have, fact, members) for have in known) for fact in plain
    )


def _check_need(program: ProgramDeclaration, contracts: Contracts) -> Iterator[Diagnostic]:
    if program.requires is not None and _follows(
        program.achieves, _plain(program.requires), contracts.members
    ):
        message = f"'{program.name}' requires what it achieves: it would return before its first call"
        note = Note("required here", program.requires.span)
        yield Diagnostic("W403", message, program.name_span, (note,))


def _check_guards(
    statement: Statement, program: ProgramDeclaration, contracts: Contracts
) -> Iterator[Diagnostic]:
    members = contracts.members
    known = _plain(program.requires)
    while not isinstance(statement, nodes.Call):
        condition = (
            statement.condition if isinstance(statement, nodes.When) else statement.generator.condition
        )
        said = _plain(condition)
        if condition is None or contracts.is_faulty(condition):
            pass
        elif any(contradicts(fact, have, members) for fact in said for have in known):
            message = "this never holds here: the contrary is required, or said before"
            yield Diagnostic("W402", message, condition.span)
        elif _follows(program.achieves, said, members):
            message = f"where this holds '{program.name}' has achieved all, and has returned already"
            yield Diagnostic("W402", message, condition.span)
        elif _follows(condition, known, members):
            message = "this always holds here: it is required, or said before"
            yield Diagnostic("W402", message, condition.span, fix=_without(statement))
        known += said
        statement = statement.body


def _without(statement: nodes.When | nodes.For) -> Fix | None:
    """The call alone, without its `when`."""
    body = statement.body
    if not isinstance(statement, nodes.When) or not isinstance(body, nodes.Call):
        return None
    start, end = statement.span, body.span
    whole = Span(start.path, start.line, start.column, end.end_line, end.end_column)
    return Fix(whole, format_statement(body)[0])


def _check_itself(statement: Statement, contracts: Contracts) -> Iterator[Diagnostic]:
    call = innermost(statement)
    for fact in contracts.contract(call, "achieves"):
        match fact:
            case Atom(predicate, (one, other)) if one == other and predicate in IRREFLEXIVE:
                if one not in (ANY, EVERY):
                    what = format_expression(fact)
                    message = f"this would achieve {what}, and nothing is {predicate} itself"
                    yield Diagnostic("W404", message, head(call.span, call.callee))


def _check_promise(program: ProgramDeclaration, contracts: Contracts) -> Iterator[Diagnostic]:
    """Check that each promised object is at least mentioned in the body, or promised by a call."""
    if not program.body or program.achieves is None:
        return
    promised = [fact for each in program.body for fact in contracts.promised(each)]
    spoken = set[str]().union(*map(_spoken, program.body))
    # What the hand holds already needs no mention: it is moved with the hand.
    carried = [fact for fact in facts(program.requires) if contracts.achievers(fact)]
    spoken = spoken.union(*map(mentions, carried))
    parameters = {each.name for each in program.parameters}
    for part in conjuncts(program.achieves):
        lacking = list(_lacking(facts(part), promised, contracts))
        if not lacking:
            continue
        silent = sorted(mentions(part) & parameters - spoken)
        about = format_expression(part)
        if silent:
            message = f"{about} is promised, and no call speaks of '{silent[0]}'"
        elif (turned := _turned(lacking, promised)) and not _calls_api(program, contracts):
            message = f"{about} is promised; the calls achieve '{turned}' for other things, never for these"
        else:
            continue
        yield Diagnostic("N401", message, part.span)


def _spoken(statement: Statement) -> set[str]:
    names = {name for argument in innermost(statement).arguments for name in mentions(argument)}
    while not isinstance(statement, nodes.Call):
        if isinstance(statement, nodes.For):
            names |= mentions(statement.generator)
        else:
            names |= mentions(statement.condition)
        statement = statement.body
    return names


def _lacking(
    wanted: Iterable[Expression],
    promised: Sequence[Expression],
    contracts: Contracts,
    depth: int = DEEPEST,
) -> Iterator[Expression]:
    """What no call promises; of a composed predicate, those of its parts. What nobody achieves is given."""
    for fact in wanted:
        if not contracts.achievers(fact) or any(implies(have, fact, contracts.members) for have in promised):
            continue
        parts = contracts.parts(fact) if depth else []
        if parts:
            yield from _lacking(parts, promised, contracts, depth - 1)
        else:
            yield fact


def _turned(lacking: Sequence[Expression], promised: Sequence[Expression]) -> str:
    """The predicate of what lacks that the calls promise of other things, if there is one."""
    predicates = {fact.predicate for fact in promised if isinstance(fact, Atom)}
    same = (each.predicate for each in lacking if isinstance(each, Atom) and each.predicate in predicates)
    return next(same, "")


def _calls_api(program: ProgramDeclaration, contracts: Contracts) -> bool:
    """An api may change more than it promises."""
    return any(innermost(each).callee in contracts.table.apis for each in program.body)
