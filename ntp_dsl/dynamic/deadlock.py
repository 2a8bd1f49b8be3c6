"""Where an expert stands still: the program in which no statement is due, and why each was passed over."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from ntp_dsl.language.registry import Api
from ntp_dsl.language.syntax import nodes
from ntp_dsl.language.syntax.visitors import innermost
from ntp_dsl.policies.expert import Expert, Instance
from ntp_dsl.semantics.observation import Argument
from ntp_dsl.semantics.state import Fact, State

HOLDS = "what it achieves holds already"


@dataclass(frozen=True)
class Standstill:
    """A call that is unfinished, what it lacks, and for each statement why it is not called."""

    program: str
    arguments: tuple[Argument, ...]
    lacks: tuple[Fact, ...]
    passed_over: tuple[tuple[nodes.Statement, str], ...]


def standstill(
    expert: Expert, program: str, arguments: tuple[Argument, ...], state: State
) -> Standstill | None:
    """Follows calls that would return at once, down to a body in which nothing is due."""
    row = expert.registry.programs[program]
    scope = dict(zip((p.name for p in row.parameters), arguments, strict=True))
    lacks = [fact for fact in state.literals(row.achieves, scope) if not state.holds(fact)]
    required = state.literals(row.requires, scope)
    if row.in_python or not lacks or not all(map(state.holds, required)):
        return None
    read = list(reversed(list(expert.read_body(row, scope, set(lacks), state))))
    for _, instance, is_due in read:
        if instance and is_due and not instance.lacks and instance.call:
            callee = expert.registry[instance.call.callee]
            if isinstance(callee, Api):
                return None
            return standstill(expert, callee.name, instance.call.arguments, state)
    reasons = tuple(_reasons(read))
    return Standstill(program, arguments, tuple(lacks), reasons)


def _reasons(
    read: list[tuple[nodes.Statement, Instance | None, bool]],
) -> Iterator[tuple[nodes.Statement, str]]:
    for statement, instance, is_due in read:
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
        return f"{called} requires {sorted(map(str, instance.lacks))[0]}, and nothing before provides it"
    return f"every call of {called} would return at once, or lacks what it requires"
