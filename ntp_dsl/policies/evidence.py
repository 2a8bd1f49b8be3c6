"""What a decision rests on, for traces: facts with their probabilities, and what became of each statement."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from ntp_dsl.language.registry import Program
from ntp_dsl.policies.expert import Expert
from ntp_dsl.semantics.observation import Argument
from ntp_dsl.semantics.state import Fact, State
from ntp_dsl.traces.decision import FactProbability, StatementStatus, Status

MOST = 200  # facts that a decision reports


def evidence(
    expert: Expert, row: Program, arguments: tuple[Argument, ...], state: State
) -> tuple[tuple[Fact, ...], tuple[StatementStatus, ...]]:
    """Return the literals of the contract and the statements, and what the rule makes of each statement."""
    scope = row.bind(arguments)
    achieves, requires = state.literals(row.achieves, scope), state.literals(row.requires, scope)
    found = dict.fromkeys([*achieves, *requires])
    statements: list[StatementStatus] = []
    needed = {fact for fact in achieves if not state.holds(fact)}
    if needed and all(state.holds(fact) for fact in requires):
        for statement, instance, is_due in expert.read_body(row, scope, needed, state):
            status = Status.ABSENT
            lacks: frozenset[Fact] = frozenset()
            if instance is not None:
                status = Status.ACHIEVED if instance.achieved else Status.DUE if is_due else Status.PASSED
                lacks = instance.lacks
                found |= dict.fromkeys(sorted([*instance.provides, *instance.names], key=str))
            call = instance.call if instance is not None else None
            statements.append(
                StatementStatus(
                    line=(call.span if call is not None and call.span.line else statement.span).line,
                    status=status,
                    callee=call.callee if call else "",
                    arguments=call.arguments if call else (),
                    lacks=tuple(sorted(map(str, lacks))),
                )
            )
    return tuple(found)[:MOST], tuple(reversed(statements))


def weighed(facts: Sequence[Fact], probability: Callable[[Fact], Any]) -> tuple[FactProbability, ...]:
    """Return facts as a trace keeps them."""
    return tuple(FactProbability(str(fact), rounded(probability(fact))) for fact in facts)


def rounded(probability: Any) -> float:
    """Return a probability as a trace keeps it."""
    return round(min(1.0, max(0.0, float(probability))), 4)
