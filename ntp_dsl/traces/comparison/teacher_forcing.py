"""A policy that was asked at every state of another's trace: what it would have done there.

Teacher-forced, so that each decision is judged by itself: what went wrong before has no part in it. A
replayed trace has the calls of the trace that it followed, and with each decision the answer that was given.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from ntp_dsl.semantics.observation import Argument
from ntp_dsl.traces import failure_attribution
from ntp_dsl.traces.comparison.comparison import Divergence
from ntp_dsl.traces.comparison.comparison_rules import Kind, Rules
from ntp_dsl.traces.comparison.confidence import certainty
from ntp_dsl.traces.schema import ROOT, Call, Trace, from_json, to_json


def answer_row(
    callee: str | None, kind: str, arguments: tuple[Argument, ...], scope: Any
) -> Mapping[str, Any]:
    """What was answered, for a decision's line: a callee of None is a return."""
    shown = [to_json(argument) for argument in arguments]
    return {"callee": callee, "kind": kind, "arguments": shown, "scope": scope}


def disagreements(a: Trace, b: Trace, rules: Rules) -> list[Divergence]:
    """Of a replayed trace with the one that it follows: every answer that is not what was done."""
    found = []
    for call, returns in a.events():
        if call.id >= len(b.calls):
            break  # the replay was cut off
        twin = b.calls[call.id]
        decision = twin.ending if returns else twin.decision
        answer = _answer(decision)
        if answer is None:
            continue
        kind = _kind(None if returns else call, answer, rules)
        if kind is not None:
            found.append(_divergence(kind, call, returns, answer, decision))
    return found


def asked(trace: Trace) -> int:
    """How many decisions of a replayed trace were answered."""
    return sum(_answer(d) is not None for call in trace.calls for d in (call.decision, call.ending))


def _answer(decision: Mapping[str, Any]) -> Call | None:
    """The call that was answered, without a name where it is a return; None where nothing was asked."""
    row = decision.get("answer")
    if not isinstance(row, dict):
        return None
    arguments = tuple(from_json(value) for value in row.get("arguments", ()))
    scope = row.get("scope")
    frames = None if scope is None else (int(scope[0]), int(scope[1]))
    callee, kind = row.get("callee"), str(row.get("kind"))
    return Call(-1, ROOT, kind, "" if callee is None else str(callee), arguments, frames, 0, 0)


def _kind(right: Call | None, answer: Call, rules: Rules) -> Kind | None:
    if right is None or not answer.name:
        if right is None and not answer.name:
            return None
        return Kind.TOO_LATE if right is None else Kind.TOO_EARLY
    if answer.name != right.name:
        return Kind.PROGRAM
    if rules.label(answer) != rules.label(right) or not rules.same_numbers(right, answer):
        return Kind.ARGUMENT
    return None if rules.same_scope(right, answer) else Kind.SCOPE


def _divergence(
    kind: Kind, call: Call, returns: bool, answer: Call, decision: Mapping[str, Any]
) -> Divergence:
    number = None if returns else call.id
    caller = call.id if returns else call.parent
    right, given = (None if returns else call), (answer if answer.name else None)
    source = str((call.ending if returns else call.decision).get("source", ""))
    sure = certainty(kind, decision, right, given)
    return Divergence(
        kind, caller, caller, number, number, failure_attribution.DECISION, source, sure, None, answer
    )
