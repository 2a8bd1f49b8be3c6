"""What is wrong with contracts: requirements that nothing provides, and promises that are not made."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from ntp_dsl.language.checks.condition_lints import check_program
from ntp_dsl.language.checks.success_checks import check_success
from ntp_dsl.language.diagnostics.diagnostics import Diagnostic, Fix, Note
from ntp_dsl.language.logic.facts import EVERY
from ntp_dsl.language.logic.preconditions import Contracts, Lack
from ntp_dsl.language.names.signatures import head
from ntp_dsl.language.repairs import contract_repairs
from ntp_dsl.language.syntax.formatter import format_expression
from ntp_dsl.language.syntax.nodes import Expression, ProgramDeclaration, TaskDeclaration


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
    yield from _missing(list(contracts.lacks(declaration)), contracts)


def _no_promise(program: ProgramDeclaration, contracts: Contracts) -> Diagnostic:
    promised = contract_repairs.promise(contracts, program)
    text = format_expression(promised) if promised else "on(item, support)"
    fix = contract_repairs.add_clause(program, f"achieves {text}") if promised else None
    message = f"program '{program.name}' does not say what it achieves"
    help = f"say what holds once it has done its work: achieves {text}"
    return Diagnostic("E401", message, program.name_span, help=help, fix=fix)


def _missing(lacks: Sequence[Lack], contracts: Contracts) -> Iterator[Diagnostic]:
    """What one call lacks, and one change would mend, is one mistake."""
    repairs = [contract_repairs.repair(contracts, lack) for lack in lacks]
    told: set[int] = set()
    for number, (lack, repaired) in enumerate(zip(lacks, repairs, strict=True)):
        if number in told:
            continue
        alike = [
            other
            for other in range(number, len(lacks))
            if other == number or (repaired is not None and repairs[other] == repaired)
            if (lacks[other].index, lacks[other].certain) == (lack.index, lack.certain)
        ]
        told.update(alike)
        yield _missing_of_call(lack, [lacks[each].fact for each in alike], repaired, contracts)


def _missing_of_call(
    lack: Lack, lacking: Sequence[Expression], repaired: tuple[Fix, str] | None, contracts: Contracts
) -> Diagnostic:
    callee = contracts.table.callable(lack.call.callee)
    assert callee is not None
    what = " and ".join(format_expression(fact).replace(EVERY.id, "any") for fact in lacking)
    message = f"'{callee.name}' requires {what}, and nothing provides that before it"
    help = f"add it to what '{lack.program.name}' requires"
    names = [name for name in contracts.achievers(lack.fact) if name != lack.program.name]
    if names:
        help = f"call what achieves it ({', '.join(names)}) before, or {help}"
    fix, help = repaired or (None, help)
    note = Note(f"'{callee.name}' is declared here", callee.name_span)
    code = "E403" if lack.certain else "N403"
    span = head(lack.call.span, lack.call.callee)
    return Diagnostic(code, message, span, (note,), help, fix)
