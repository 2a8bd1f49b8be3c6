"""A policy that was asked at every state of another's trace: what it would have done there.

Teacher-forced, so that each decision is judged by itself: what went wrong before has no part in it. A
replayed trace has the calls of the trace that it followed, and with each decision the answer that was given.
"""

from __future__ import annotations

from ntp_dsl.traces.comparison.comparison import Divergence
from ntp_dsl.traces.comparison.comparison_rules import Kind, Rules
from ntp_dsl.traces.comparison.confidence import confidence
from ntp_dsl.traces.decision import Answer, Decision
from ntp_dsl.traces.schema import ROOT, Attribution, Call, CallKind, Trace


def disagreements(a: Trace, b: Trace, rules: Rules) -> list[Divergence]:
    """Return every answer of a replayed trace that is not what the trace did that it follows."""
    found = []
    for call, returns in a.events():
        if call.id >= len(b.calls):
            break  # the replay was cut off
        twin = b.calls[call.id]
        decision = twin.ending if returns else twin.decision
        if decision is None or decision.answer is None:
            continue
        kind = _kind(None if returns else call, decision.answer, rules)
        if kind is not None:
            found.append(_divergence(kind, call, returns, decision, decision.answer))
    return found


def asked(trace: Trace) -> int:
    """Return how many decisions of a replayed trace were answered."""
    decisions = (each for call in trace.calls for each in (call.decision, call.ending))
    return sum(each is not None and each.answer is not None for each in decisions)


def _answered(answer: Answer) -> Call | None:
    """Return the call that was answered, as calls are compared; None for a return."""
    if answer.callee is None:
        return None
    kind = CallKind.API if answer.is_api else CallKind.PROGRAM
    return Call(-1, ROOT, kind, answer.callee, answer.arguments, answer.scope, 0, 0)


def _kind(right: Call | None, answer: Answer, rules: Rules) -> Kind | None:
    given = _answered(answer)
    if right is None or given is None:
        if right is None and given is None:
            return None
        return Kind.TOO_LATE if right is None else Kind.TOO_EARLY
    if given.name != right.name:
        return Kind.PROGRAM
    if rules.label(given) != rules.label(right) or not rules.same_numbers(right, given):
        return Kind.ARGUMENT
    return None if rules.same_scope(right, given) else Kind.SCOPE


def _divergence(kind: Kind, call: Call, returns: bool, decision: Decision, answer: Answer) -> Divergence:
    number = None if returns else call.id
    caller = call.id if returns else call.parent
    followed = call.ending if returns else call.decision
    return Divergence(
        kind,
        caller,
        caller,
        number,
        number,
        Attribution.DECISION,
        followed.source if followed else "",
        confidence(kind, decision, None if returns else call, _answered(answer)),
        None,
        answer,
    )
