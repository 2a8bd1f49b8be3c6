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
    asked = {each for api in apis for each in _signed(api.requires, table)}
    asked |= {each for program in programs for each in _signed(program.achieves, table)}
    asked |= {each for task in tasks for each in _signed(task.success, table)}
    given = {fact.predicate for task in tasks for fact in task.facts}
    for each in own:
        name = each.name
        if (name, True) in asked and (name, True) not in achieved and name not in given:
            message = f"no api achieves '{name}', and nothing says that it holds at the start: it never does"
            help = "let the api that brings it about achieve it, or list it under 'initially'"
            yield Diagnostic("W406", message, each.name_span, help=help)
        begins = name in given or (name, True) in achieved
        if (name, False) in asked and begins and (name, False) not in achieved:
            message = f"no api achieves 'not {name}(...)', so that where '{name}' holds it always will"
            help = f"let the api that ends it achieve: not {name}(...)"
            yield Diagnostic("W406", message, each.name_span, help=help)


def _signed(expression: Expression | None, table: SymbolTable, holds: bool = True) -> Iterator[Signed]:
    """Yield the predicates that an expression says something of, those in bodies too, and what it says."""
    match expression:
        case nodes.Atom(predicate=name):
            declared = table.predicates.get(name)
            if declared is not None and declared.body is not None:
                yield from _signed(declared.body, table, holds)
            else:
                yield name, holds
        case nodes.Not(value):
            yield from _signed(value, table, not holds)
        case nodes.And(values) | nodes.Or(values):
            for value in values:
                yield from _signed(value, table, holds)
        case nodes.Quantified(body=body):
            yield from _signed(body, table, holds)
