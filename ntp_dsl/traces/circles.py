"""Calls of a program that come round again and again, and which of them undoes what another achieves."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from ntp_dsl.traces.decision import StatementStatus, Status
from ntp_dsl.traces.phrases import format_call
from ntp_dsl.traces.schema import ROOT, Call, CallOutcome, Ending
from ntp_dsl.traces.trace import Trace

ROUNDS = 3  # of which one is a circle
LONGEST = 12  # calls of a round


@dataclass(frozen=True)
class Circle:
    """Calls that a program makes in turn, again and again.

    Args:
        caller: the program.
        calls: of the last round that is whole.
        rounds: how often they were made.
    """

    caller: Call
    calls: tuple[Call, ...]
    rounds: int

    @property
    def failing(self) -> list[Call]:
        """The calls that do not succeed, or not with what they promise."""
        return [call for call in self.calls if not call.succeeded or call.execution.unmet]

    def starving(self) -> tuple[StatementStatus, list[str]] | None:
        """Return the first statement that is due at every call and always lacks some facts, and these."""
        others = [call.decision.statements for call in self.calls[1:]]
        for statement in self.calls[0].decision.statements:
            lacks = {*statement.lacks} if statement.status is Status.DUE else set()
            for statements in others:
                lacks &= {
                    fact
                    for each in statements
                    if (each.line, each.callee, each.status) == (statement.line, statement.callee, Status.DUE)
                    for fact in each.lacks
                }
            if lacks:
                return statement, sorted(lacks)
        return None

    def undone(self) -> tuple[str, Call, Call] | None:
        """Return a fact that one of the calls brings about and another one ends, and these two."""
        found = [*self._undone()]
        own = [each for each in found if each[0] in _promised(each[1])]
        return next(iter(own or found), None)

    def _undone(self) -> Iterator[tuple[str, Call, Call]]:
        truths = [{each.fact: each.truth for each in call.decision.facts} for call in self.calls]
        count = len(self.calls)
        after = {n: truths[(n + 1) % count] for n in range(count)}
        for fact in truths[0]:
            begun = [n for n in range(count) if truths[n].get(fact) is False and after[n].get(fact) is True]
            ended = [n for n in range(count) if truths[n].get(fact) is True and after[n].get(fact) is False]
            if begun and ended:
                yield fact, self.calls[begun[0]], self.calls[ended[0]]


def _promised(call: Call) -> set[str]:
    """Return the facts that a program saw when it returned: among them is what it promises."""
    return {each.fact for each in call.return_decision.facts} if call.return_decision is not None else set()


def circle(trace: Trace) -> Circle | None:
    """Return what a run went round in at its end; None where it did not come round to the same states."""
    if trace.end is None or trace.end.ending is not Ending.CIRCULAR:
        return None
    callers = [
        call for call in trace.calls if call.is_program and not call.succeeded
    ]  # others had ended well
    found = (_round(call, trace.children(call.id)) for call in callers)
    circles = [each for each in found if each is not None]
    return max(circles, key=lambda each: each.rounds * len(each.calls), default=None) or _of_roots(trace)


def _of_roots(trace: Trace) -> Circle | None:
    """Return the circle that the task's own program makes, over all times that it was run."""
    roots = trace.children(ROOT)
    return _round(roots[-1], [call for root in roots for call in trace.children(root.id)]) if roots else None


def _round(caller: Call, made: Sequence[Call]) -> Circle | None:
    """Return the round at the end of some calls, the last of which may not have returned."""
    whole = [call for call in made if call.end_frame is not None and call.outcome is not CallOutcome.STOPPED]
    texts = [format_call(call) for call in whole]
    for length in range(1, min(LONGEST, len(texts) // ROUNDS) + 1):
        rounds = 1
        last = texts[-length:]
        while texts[-(rounds + 1) * length : -rounds * length] == last:
            rounds += 1
        if rounds >= ROUNDS:
            return Circle(caller, tuple(whole[-length:]), rounds)
    return None
