"""Checks of contracts: requirements that nothing provides, and promises that are not made."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from ntp_dsl.language.checks.condition_lints import check_program
from ntp_dsl.language.checks.shown_lists import check_lists
from ntp_dsl.language.checks.success_checks import check_success
from ntp_dsl.language.diagnostics.diagnostics import Diagnostic, Fix, Note
from ntp_dsl.language.logic.facts import EVERY
from ntp_dsl.language.logic.preconditions import Contracts, UnmetRequirement
from ntp_dsl.language.names.signatures import leading_span
from ntp_dsl.language.repairs import contract_repairs
from ntp_dsl.language.syntax.formatter import format_expression, format_statement
from ntp_dsl.language.syntax.nodes import Call, Expression, ProgramDeclaration, Statement, TaskDeclaration


def check_contract(
    declaration: ProgramDeclaration | TaskDeclaration, contracts: Contracts
) -> Iterator[Diagnostic]:
    """Check that each requirement of a call is provided before it, by contract, earlier call or loop; and
    that a task calls success what its program promises."""
    if isinstance(declaration, TaskDeclaration):
        yield from check_success(contracts, declaration)
        return
    yield from check_program(contracts, declaration)
    if declaration.achieves is None:
        yield _no_promise(declaration, contracts)
    else:
        yield from check_lists(declaration, contracts)
    yield from _missing(list(contracts.unmet(declaration)), contracts)


def _no_promise(program: ProgramDeclaration, contracts: Contracts) -> Diagnostic:
    promised = contract_repairs.likely_promise(contracts, program)
    text = format_expression(promised) if promised else "on(item, support)"
    fix = contract_repairs.add_clause(program, f"achieves {text}") if promised else None
    message = f"program '{program.name}' does not say what it achieves"
    help = f"state what holds when it is done: achieves {text}"
    return Diagnostic("E401", message, program.name_span, help=help, fix=fix)


def _missing(requirements: Sequence[UnmetRequirement], contracts: Contracts) -> Iterator[Diagnostic]:
    """Yield one diagnostic for all that one call lacks and one change would provide."""
    repairs = [contract_repairs.repair(contracts, unmet) for unmet in requirements]
    reported: set[int] = set()
    for number, (unmet, repaired) in enumerate(zip(requirements, repairs, strict=True)):
        if number in reported:
            continue
        alike = [
            other
            for other in range(number, len(requirements))
            if other == number or (repaired is not None and repairs[other] == repaired)
            if (requirements[other].index, requirements[other].certain) == (unmet.index, unmet.certain)
        ]
        reported.update(alike)
        yield _missing_of_call(unmet, [requirements[each].fact for each in alike], repaired, contracts)


def _is_one_of_several(unmet: UnmetRequirement, contracts: Contracts) -> bool:
    """Return whether another statement of the program brings about what a call does."""
    others = {each.callee for each in _calls(unmet.program.body)} - {unmet.call.callee}
    promised = contracts.contract(unmet.call, "achieves")
    return any(not others.isdisjoint(contracts.achievers(each)) for each in promised)


def _calls(body: Sequence[Statement]) -> Iterator[Call]:
    for statement in body:
        while not isinstance(statement, Call):
            statement = statement.body
        yield statement


def _missing_of_call(
    unmet: UnmetRequirement,
    facts: Sequence[Expression],
    repaired: tuple[Fix, str] | None,
    contracts: Contracts,
) -> Diagnostic:
    callee = contracts.table.callable(unmet.call.callee)
    assert callee is not None
    what = " and ".join(format_expression(fact).replace(EVERY.id, "any") for fact in facts)
    message = f"'{callee.name}' requires {what}, and nothing before it provides that"
    help = f"add it to what '{unmet.program.name}' requires"
    names = [name for name in contracts.achievers(unmet.fact) if name != unmet.program.name]
    if names:
        help = f"call what achieves it ({', '.join(names)}) first, or {help}"
    fix, help = repaired or (None, help)
    if _is_one_of_several(unmet, contracts):
        call = format_statement(unmet.call)[0].strip()
        help += f"; or, as it is one of several ways: when {what}: {call}"
    note = Note(f"'{callee.name}' is declared here", callee.name_span)
    code = "E403" if unmet.certain else "N403"
    span = leading_span(unmet.call.span, unmet.call.callee)
    return Diagnostic(code, message, span, (note,), help, fix)
