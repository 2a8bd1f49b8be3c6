"""Deadlocks of an expert: a program in which no statement is due, and why each was skipped."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from ntp_dsl.language.registry import Api
from ntp_dsl.language.syntax import nodes
from ntp_dsl.language.syntax.visitors import innermost
from ntp_dsl.policies.expert import Expert, Instance
from ntp_dsl.semantics.observation import Argument
from ntp_dsl.semantics.state import Fact, State

HOLDS = "what it achieves already holds"


@dataclass(frozen=True)
class Deadlock:
    """An unfinished call, its unmet goals, and for each statement the reason why it is not called."""

    program: str
    arguments: tuple[Argument, ...]
    unmet: tuple[Fact, ...]
    skipped: tuple[tuple[nodes.Statement, str], ...]


def find_deadlock(
    expert: Expert, program: str, arguments: tuple[Argument, ...], state: State
) -> Deadlock | None:
    """Follow calls that would return at once, and return the program in which no statement is due."""
    row = expert.registry.programs[program]
    scope = row.bind(arguments)
    unmet = [fact for fact in state.literals(row.achieves, scope) if not state.holds(fact)]
    required = state.literals(row.requires, scope)
    if row.in_python or not unmet or not all(map(state.holds, required)):
        return None
    statements = list(reversed(list(expert.read_body(row, scope, set(unmet), state))))
    for _, instance, is_due in statements:
        call = instance and (instance.call or instance.vain)
        if instance and call and is_due and not instance.lacks:
            callee = expert.registry[call.callee]
            if isinstance(callee, Api):
                return None
            if found := find_deadlock(expert, callee.name, call.arguments, state):
                return found
    reasons = tuple(_reasons(statements))
    return Deadlock(program, arguments, tuple(unmet), reasons)


def _reasons(
    statements: list[tuple[nodes.Statement, Instance | None, bool]],
) -> Iterator[tuple[nodes.Statement, str]]:
    for statement, instance, is_due in statements:
        yield statement, _reason(statement, instance, is_due)


def _reason(statement: nodes.Statement, instance: Instance | None, is_due: bool) -> str:
    called = innermost(statement).callee
    if instance is None:
        return "its condition does not hold"
    if instance.achieved and not instance.provides and isinstance(statement, nodes.For):
        return "no element meets the conditions of the loop"
    if instance.achieved:
        return HOLDS
    if not is_due:
        return "nothing that it achieves is needed"
    if instance.lacks:
        return (
            f"{called} requires {sorted(map(str, instance.lacks))[0]}, and no earlier statement provides it"
        )
    return f"every call of {called} would return at once, or does not meet its 'requires'"
