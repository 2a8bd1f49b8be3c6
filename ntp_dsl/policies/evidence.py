"""What a decision rests on, for traces: facts with their probabilities, and what became of each statement."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from ntp_dsl.language.registry import Program
from ntp_dsl.language.syntax import nodes
from ntp_dsl.policies.expert import Expert, Instance, NextCall
from ntp_dsl.semantics.facts import Fact
from ntp_dsl.semantics.observation import Argument
from ntp_dsl.semantics.state import State
from ntp_dsl.traces.decision import FactProbability, StatementStatus, Status

MOST = 200  # facts that a decision reports


@dataclass(frozen=True)
class BodyStatement:
    """A statement of a program's body in a state: what it stands for there, and what the rule makes of it."""

    statement: nodes.Statement
    instance: Instance | None  # None where its `when` is false
    is_due: bool

    @property
    def is_about_nothing(self) -> bool:
        """Whether it is a loop of which no element meets the conditions."""
        return (
            isinstance(self.statement, nodes.For) and self.instance is not None and not self.instance.provides
        )

    @property
    def status(self) -> Status:
        if self.instance is None or self.is_about_nothing:
            return Status.ABSENT
        if self.instance.achieved:
            return Status.ACHIEVED
        if not self.is_due:
            return Status.PASSED
        return Status.VAIN if self.instance.call is None else Status.DUE

    @property
    def call(self) -> NextCall | None:
        """Return the call that it stands for, or would; None where it stands for none."""
        return (self.instance.call or self.instance.vain) if self.instance is not None else None

    @property
    def span(self) -> nodes.Span:
        """Return the place of its call, or else its own."""
        return self.call.span if self.call is not None and self.call.span.line else self.statement.span

    @property
    def lacks(self) -> tuple[str, ...]:
        """Return the facts that its call requires and that do not hold."""
        return tuple(sorted(map(str, self.instance.lacks))) if self.instance is not None else ()

    @property
    def record(self) -> StatementStatus:
        """Return what a trace keeps of it."""
        call = self.call
        return StatementStatus(
            line=self.span.line,
            status=self.status,
            callee=call.callee if call else "",
            arguments=call.arguments if call else (),
            lacks=self.lacks,
        )


def body_statements(
    expert: Expert, row: Program, arguments: tuple[Argument, ...], state: State
) -> tuple[BodyStatement, ...]:
    """Return what the rule makes of each statement; none where the program does not read its body."""
    requires, achieves = state.contract(row.name, arguments)
    needed = {fact for fact in achieves if not state.holds(fact)}
    if not needed or not all(map(state.holds, requires)):
        return ()
    return tuple(BodyStatement(*each) for each in expert.read_body(row, arguments, needed, state))[::-1]


def evidence(
    expert: Expert, row: Program, arguments: tuple[Argument, ...], state: State
) -> tuple[tuple[Fact, ...], tuple[StatementStatus, ...]]:
    """Return the literals of the contract and the statements, and what the rule makes of each statement."""
    requires, achieves = state.contract(row.name, arguments)
    found = dict.fromkeys([*achieves, *requires])
    statements = body_statements(expert, row, arguments, state)
    for each in reversed(statements):
        if each.instance is not None:
            found |= dict.fromkeys(sorted([*each.instance.provides, *each.instance.names], key=str))
    return tuple(found)[:MOST], tuple(each.record for each in statements)


def weighed(facts: Sequence[Fact], probability: Callable[[Fact], Any]) -> tuple[FactProbability, ...]:
    """Return facts as a trace keeps them."""
    return tuple(FactProbability(str(fact), rounded(probability(fact))) for fact in facts)


def rounded(probability: Any) -> float:
    """Return a probability as a trace keeps it."""
    return round(min(1.0, max(0.0, float(probability))), 4)
