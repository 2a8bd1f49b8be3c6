"""A trace's calls and motion as a page takes them: plain texts and finite numbers."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from math import isfinite
from typing import Any

import msgspec

from ntp_dsl.semantics.geometry import Vector
from ntp_dsl.traces.decision import Answer
from ntp_dsl.traces.decision import Ranking as Alternatives
from ntp_dsl.traces.failure_attribution import of_call
from ntp_dsl.traces.phrases import called, shown
from ntp_dsl.traces.schema import Call, Trace
from ntp_dsl.traces.sources import statement
from ntp_dsl.traces.times import Times

EVIDENCE = 300  # characters of it that are told
Ranking = list[tuple[str, float]]
Moment = tuple[int, float, Vector, bool, Mapping[str, Vector]]


def call_row(trace: Trace, call: Call, times: Times) -> dict[str, Any]:
    """Return a call as the page shows it."""
    source = call.decision.source
    return {
        "name": call.name,
        "program": call.is_program,
        "arguments": ", ".join(map(shown, call.arguments)),
        "scope": call.scope,
        "outcome": call.outcome or "",
        "probability": call.decision.probability,
        "times": [round(spent, 5) for spent in (times.deciding, times.planning, times.moving)],
        "frame": call.frame,
        "end_frame": call.end_frame,
        "source": source,
        "statement": statement(trace, source),
        "attributed_to": of_call(call) or "",
        "disturbances": call.execution.disturbances,
        "evidence": _evidence(call.execution.evidence),
        "alternatives": list(_alternatives(call)),
    }


def number(value: object) -> float | None:
    """Return a number as JSON has it, finite; None for what is none."""
    return float(value) if isinstance(value, int | float) and isfinite(value) else None


def _evidence(measured: Mapping[str, Any]) -> str:
    return msgspec.json.encode(measured).decode()[:EVIDENCE] if measured else ""


def _alternatives(call: Call) -> Iterator[tuple[str, Ranking]]:
    """Yield what the decision might have been instead: callees, arguments, scopes, and the caller's end."""
    decision = call.decision
    yield from _ranking("callee", decision.callees)
    for place, ranking in enumerate(decision.arguments, 1):
        yield from _ranking(f"argument {place}", ranking)
    yield from _ranking("scope", decision.scopes)
    if decision.end_probability is not None:
        yield "or to return", [("end of the caller", decision.end_probability)]
    if call.ending is not None and call.ending.end_probability is not None:
        yield "its own end", [("end", call.ending.end_probability)]
    if decision.answer is not None:
        yield "answered", [(_answered(decision.answer), decision.probability or 0.0)]


def _answered(answer: Answer) -> str:
    return "return" if answer.callee is None else called(answer.callee, answer.arguments)


def _ranking(title: str, ranking: Alternatives[Any]) -> Iterator[tuple[str, Ranking]]:
    if ranking:
        yield title, [(_alternative(each.value), each.probability) for each in ranking]


def _alternative(value: object) -> str:
    if value is None:
        return "none"
    return f"frames {value[0]} – {value[1]}" if isinstance(value, tuple) else str(value)


def motion(trace: Trace) -> list[Moment]:
    """Return frame, time, hand, closed and what moved; of the calls' states where motion was not traced."""
    if trace.motions:
        return [(m.frame, m.time, m.gripper, m.closed, m.positions) for m in trace.motions]
    found: list[Moment] = []
    seen: Mapping[str, Any] = {}
    last = -1
    for call in trace.calls:
        if call.state != last:
            last, state = call.state, trace.states[call.state]
            moved = {name: p for name, p in state.positions.items() if seen.get(name) != p}
            seen = state.positions
            found.append((call.frame, call.frame / 10, state.gripper, state.closed, moved))
    return found
