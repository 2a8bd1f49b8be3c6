"""A trace's calls and motion as a page takes them: plain texts and finite numbers."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from math import isfinite
from typing import Any

from ntp_dsl.semantics.observation import Vector
from ntp_dsl.traces.failure_attribution import of_call
from ntp_dsl.traces.phrases import shown
from ntp_dsl.traces.schema import Call, Trace
from ntp_dsl.traces.sources import statement
from ntp_dsl.traces.times import Times

EVIDENCE = 300  # characters of it that are told
Ranking = list[tuple[str, float]]
Moment = tuple[int, float, Vector, bool, Mapping[str, Vector]]


def call_row(trace: Trace, call: Call, times: Times) -> dict[str, Any]:
    source = str(call.decision.get("source", ""))
    return {
        "name": call.name,
        "program": call.is_program,
        "arguments": ", ".join(map(shown, call.arguments)),
        "scope": call.scope,
        "outcome": call.outcome,
        "probability": number(call.probability),
        "times": [round(spent, 5) for spent in (times.deciding, times.planning, times.moving)],
        "frame": call.frame,
        "end_frame": call.end_frame,
        "source": source,
        "statement": statement(trace, source),
        "blame": of_call(call),
        "disturbances": call.disturbances,
        "evidence": _evidence(call.details.get("evidence")),
        "alternatives": list(_alternatives(call)),
    }


def number(value: object) -> float | None:
    """As JSON has them: finite."""
    return float(value) if isinstance(value, int | float) and isfinite(value) else None


def _evidence(value: object) -> str:
    return json.dumps(value)[:EVIDENCE] if value else ""


def _alternatives(call: Call) -> Iterator[tuple[str, Ranking]]:
    """What the decision might have been instead: callees, objects, scopes, and the caller's end."""
    decision = call.decision
    yield from _ranking("callee", decision.get("top"))
    for title, field in (("object", "pointers"), ("value", "values")):
        rankings = decision.get(field)
        for place, ranking in enumerate(rankings if isinstance(rankings, list) else (), 1):
            yield from _ranking(f"{title} {place}", ranking)
    yield from _ranking("scope", decision.get("scopes"))
    if (end := number(decision.get("end_probability"))) is not None:
        yield "or to return", [("end of the caller", end)]
    if (end := number(call.ending.get("end_probability"))) is not None:
        yield "its own end", [("end", end)]
    answer = call.decision.get("answer")
    if isinstance(answer, dict):
        yield "answered", [(_answered(answer), number(decision.get("probability")) or 0.0)]


def _answered(answer: Mapping[str, Any]) -> str:
    if answer.get("callee") is None:
        return "return"
    arguments = answer.get("arguments")
    return f"{answer['callee']}({', '.join(map(str, arguments if isinstance(arguments, list) else ()))})"


def _ranking(title: str, ranking: object) -> Iterator[tuple[str, Ranking]]:
    found = []
    for entry in ranking if isinstance(ranking, list) else ():
        if isinstance(entry, list) and len(entry) == 2 and (p := number(entry[1])) is not None:
            found.append((_alternative(entry[0]), p))
    if found:
        yield title, found


def _alternative(value: object) -> str:
    if value is None:
        return "none"
    return f"frames {value[0]} – {value[1]}" if isinstance(value, list) and len(value) == 2 else str(value)


def motion(trace: Trace) -> list[Moment]:
    """Frame, time, hand, closed, and what moved; from the states of the calls where motion was not traced."""
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
