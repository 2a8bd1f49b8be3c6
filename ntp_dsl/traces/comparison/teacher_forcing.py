"""Teacher forcing: a policy's answers at every state of another trace, each judged independently.

A replayed trace has the calls of the original trace, and with each decision the policy's answer.
"""

from __future__ import annotations

from ntp_dsl.traces.comparison.comparison import Divergence
from ntp_dsl.traces.comparison.comparison_rules import DivergenceKind, Rules
from ntp_dsl.traces.comparison.confidence import confidence
from ntp_dsl.traces.decision import Answer, Decision
from ntp_dsl.traces.schema import ROOT, Attribution, Call, CallKind
from ntp_dsl.traces.trace import Trace


def disagreements(a: Trace, b: Trace, rules: Rules) -> list[Divergence]:
    """Return every answer of a replayed trace that differs from the original trace."""
    divergences = []
    for call, returns in a.events():
        if call.id >= len(b.calls):
            break  # the replay was cut off
        replayed = b.calls[call.id]
        decision = replayed.return_decision if returns else replayed.decision
        if decision is None or decision.answer is None:
            continue
        kind = _kind(None if returns else call, decision.answer, rules)
        if kind is not None:
            divergences.append(_divergence(kind, call, returns, decision, decision.answer))
    return divergences


def count_answers(trace: Trace) -> int:
    """Return the number of answered decisions of a replayed trace."""
    decisions = (each for call in trace.calls for each in (call.decision, call.return_decision))
    return sum(each is not None and each.answer is not None for each in decisions)


def _call_of(answer: Answer) -> Call | None:
    """Return an answer as a call that can be compared; None for a return."""
    if answer.callee is None:
        return None
    kind = CallKind.API if answer.is_api else CallKind.PROGRAM
    return Call(-1, ROOT, kind, answer.callee, answer.arguments, answer.scope, 0, 0)


def _kind(expected: Call | None, answer: Answer, rules: Rules) -> DivergenceKind | None:
    actual = _call_of(answer)
    if expected is None or actual is None:
        if expected is None and actual is None:
            return None
        return DivergenceKind.TOO_LATE if expected is None else DivergenceKind.TOO_EARLY
    if actual.name != expected.name:
        return DivergenceKind.PROGRAM
    if rules.label(actual) != rules.label(expected) or not rules.same_numbers(expected, actual):
        return DivergenceKind.ARGUMENT
    return None if rules.same_scope(expected, actual) else DivergenceKind.SCOPE


def _divergence(
    kind: DivergenceKind, call: Call, returns: bool, decision: Decision, answer: Answer
) -> Divergence:
    number = None if returns else call.id
    caller = call.id if returns else call.parent
    followed = call.return_decision if returns else call.decision
    return Divergence(
        kind,
        caller,
        caller,
        number,
        number,
        Attribution.DECISION,
        followed.source if followed else "",
        confidence(kind, decision, None if returns else call, _call_of(answer)),
        None,
        answer,
    )
