"""Facts of the state that something asks for, and that no api brings about or ends."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from ntp_dsl.language.diagnostics.diagnostics import Diagnostic
from ntp_dsl.language.names.symbol_table import SymbolTable
from ntp_dsl.language.syntax import nodes
from ntp_dsl.language.syntax.nodes import Declaration, Expression, PredicateDeclaration

Signed = tuple[str, bool]  # a predicate, and whether it is to hold


def check_state_changes(declarations: Iterable[Declaration], table: SymbolTable) -> Iterator[Diagnostic]:
    """Check the predicates of the state among some declarations, by all contracts of the table."""
    own = [each for each in declarations if isinstance(each, PredicateDeclaration) and each.is_state]
    if not own:
        return
    apis, programs, tasks = table.apis.values(), table.programs.values(), table.tasks.values()
    achieved = {each for api in apis for each in _signed(api.achieves, table)}
    promised = {each for program in programs for each in _signed(program.achieves, table)}
    promised |= {each for task in tasks for each in _signed(task.success, table)}
    asked = promised | {each for api in apis for each in _signed(api.requires, table)}
    given = {fact.predicate for task in tasks for fact in task.facts}
    for each in own:
        name = each.name
        if tasks and (name, True) in asked and (name, True) not in achieved and name not in given:
            message = f"no api achieves '{name}', and nothing says that it holds at the start: it never does"
            help = "let the api that brings it about achieve it, or list it under 'initially'"
            yield Diagnostic("W406", message, each.name_span, help=help)
        begins = name in given or (name, True) in achieved
        if (name, False) in promised and begins and (name, False) not in achieved:
            message = f"no api achieves 'not {name}(...)', so that where '{name}' holds it always will"
            help = f"let the api that ends it achieve: not {name}(...)"
            yield Diagnostic("W406", message, each.name_span, help=help)


def check_definite(api: nodes.ApiDeclaration, table: SymbolTable) -> Iterator[Diagnostic]:
    """Check that what an api achieves of the state says of each fact whether it holds then."""
    if api.achieves is not None:
        for part in _indefinite(api.achieves, table):
            message = f"this does not say which facts hold once '{api.name}' is done"
            help = "of the state an api achieves facts, or 'not' facts, joined by 'and' or under 'all'"
            yield Diagnostic("E410", message, part.span, help=help)


def _indefinite(expression: Expression, table: SymbolTable) -> Iterator[Expression]:
    """Yield the parts of a contract about the state that are neither facts nor negated ones."""
    match expression:
        case nodes.And(values):
            for value in values:
                yield from _indefinite(value, table)
        case nodes.Quantified("all", body, _):
            yield from _indefinite(body, table)
        case nodes.Not(nodes.Atom()) | nodes.Not(nodes.Quantified("some", nodes.Atom(), _)):
            return
        case nodes.Atom(arguments=arguments) if nodes.Wildcard() not in arguments:
            return
        case _:
            if any(_is_state(name, table) for name, _ in _signed(expression, table)):
                yield expression


def _is_state(name: str, table: SymbolTable) -> bool:
    declared = table.predicates.get(name)
    return declared is not None and declared.is_state


def _signed(
    expression: Expression | None,
    table: SymbolTable,
    holds: bool = True,
    within: frozenset[str] = frozenset(),
) -> Iterator[Signed]:
    """Yield the predicates that an expression says something of, those in bodies too, and what it says.

    Args:
        within: predicates in whose bodies it is: one that is defined by itself is passed over.
    """
    match expression:
        case nodes.Atom(predicate=name):
            declared = table.predicates.get(name)
            if declared is None or declared.body is None:
                yield name, holds
            elif name not in within:
                yield from _signed(declared.body, table, holds, within | {name})
        case nodes.Not(value):
            yield from _signed(value, table, not holds, within)
        case nodes.And(values) | nodes.Or(values):
            for value in values:
                yield from _signed(value, table, holds, within)
        case nodes.Quantified(quantifier=quantifier, body=body):
            yield from _signed(body, table, holds, within)
            if quantifier == "exactly":  # with more of them it is no longer so
                yield from _signed(body, table, not holds, within)
