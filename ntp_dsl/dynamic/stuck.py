"""Where an expert gets stuck: a call in a state, what it needs, and what each of its statements lacks."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from ntp_dsl.common.text import listed
from ntp_dsl.language.registry import Api, Program
from ntp_dsl.language.syntax.nodes import Span
from ntp_dsl.language.syntax.visitors import innermost
from ntp_dsl.policies.evidence import BodyStatement, body_statements
from ntp_dsl.policies.expert import Expert
from ntp_dsl.policies.left_out import why_left_out
from ntp_dsl.semantics.facts import Fact
from ntp_dsl.semantics.observation import Argument
from ntp_dsl.semantics.state import State
from ntp_dsl.traces.decision import Status
from ntp_dsl.traces.phrases import format_argument

FEW, MOST = 3, 6  # items that a part of a note lists, and a note
SKIPPED = "skipped: "  # with which the reason begins why a statement is not called


@dataclass(frozen=True)
class Stuck:
    """A call that makes no progress: what does not hold of its contract, and what the rule makes of its body.

    `way` has the statements that lead to it, the outermost first.
    """

    expert: Expert
    program: Program
    arguments: tuple[Argument, ...]
    state: State
    unmet: tuple[Fact, ...]  # of what it achieves
    lacks: tuple[Fact, ...]  # of what it requires
    statements: tuple[BodyStatement, ...]
    way: tuple[Span, ...] = ()
    is_deadlock: bool = False  # no statement is due whose call would do anything

    @property
    def call(self) -> str:
        return f"{self.program.name}({given(self.arguments)})"

    @property
    def reasons(self) -> list[tuple[Span, str]]:
        """Return where each statement of the body is, and why it is not called, or that it is due."""
        return [(each.span, self._reason(each)) for each in self.statements]

    def _reason(self, each: BodyStatement) -> str:
        called = innermost(each.statement).callee
        call = f"{called}({given(each.call.arguments)})" if each.call else called
        why = why_left_out(self.expert, each, self.program.bind(self.arguments), self.state)
        match each.status:
            case Status.ABSENT:
                about = "no element meets the conditions of the loop"
                about = about if each.is_about_nothing else "its condition does not hold"
                return f"{SKIPPED}{about}" + f": {why}" * bool(why)
            case Status.PASSED:
                return f"{SKIPPED}nothing that it achieves is needed"
            case Status.ACHIEVED:
                provided = sorted(map(str, each.instance.provides)) if each.instance else []
                named = f": {listed(provided, FEW)}" if provided else ""
                return f"{SKIPPED}what it achieves already holds{named}" + f"; {why}" * bool(why)
        if each.lacks:
            lacking = f"{call} lacks {listed(each.lacks, FEW)}"
            return f"{SKIPPED}{lacking}, and no earlier statement is due that provides it"
        if self.is_deadlock or each.status is Status.VAIN or why:
            return f"{SKIPPED}{call} would do nothing" + f": {why}" * bool(why)
        return f"due: {call}"


def stuck(
    expert: Expert, program: str, arguments: tuple[Argument, ...], state: State, way: tuple[Span, ...] = ()
) -> Stuck:
    """Return what a call needs in a state, and what each statement of its body lacks there."""
    row = expert.registry.programs[program]
    scope = row.bind(arguments)
    unmet, lacks = (
        tuple(dict.fromkeys(fact for fact in state.literals(part, scope) if not state.holds(fact)))
        for part in (row.achieves, row.requires)
    )
    statements = body_statements(expert, row, arguments, state)
    return Stuck(expert, row, arguments, state, unmet, lacks, statements, way)


def find_deadlock(
    expert: Expert, program: str, arguments: tuple[Argument, ...], state: State, way: tuple[Span, ...] = ()
) -> Stuck | None:
    """Follow calls that would return at once, and return the program in which no statement is due."""
    found = stuck(expert, program, arguments, state, way)
    if found.program.in_python or not found.unmet or found.lacks:
        return None
    for each in found.statements:
        call = each.instance and (each.instance.call or each.instance.vain)
        if call and each.is_due and not each.lacks:
            callee = expert.registry[call.callee]
            if isinstance(callee, Api):
                return None
            if inner := find_deadlock(expert, callee.name, call.arguments, state, (*way, call.span)):
                return inner
    return replace(found, is_deadlock=True)


def given(arguments: Sequence[Argument]) -> str:
    """Return the arguments of a call, lists left out."""
    return ", ".join("..." if isinstance(each, tuple) else format_argument(each) for each in arguments)
