"""The calls and the motion of a trace for a page."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from math import isfinite
from typing import Any

import msgspec

from ntp_dsl.semantics.geometry import Vector
from ntp_dsl.traces import decision as traced
from ntp_dsl.traces.decision import Answer
from ntp_dsl.traces.failure_attribution import attribute_call
from ntp_dsl.traces.page.document import Moment, PageCall, Ranking
from ntp_dsl.traces.phrases import format_argument, format_invocation, format_option
from ntp_dsl.traces.schema import Call
from ntp_dsl.traces.sources import statement
from ntp_dsl.traces.times import Times
from ntp_dsl.traces.trace import Trace

MAX_EVIDENCE = 300  # [characters]


def page_call(trace: Trace, call: Call, times: Times) -> PageCall:
    """Return a call for the page."""
    source = call.decision.source
    return PageCall(
        name=call.name,
        program=call.is_program,
        arguments=", ".join(map(format_argument, call.arguments)),
        scope=call.scope,
        outcome=call.outcome or "",
        probability=call.decision.probability,
        times=(round(times.deciding, 5), round(times.planning, 5), round(times.moving, 5)),
        frame=call.frame,
        end_frame=call.end_frame,
        source=source,
        statement=statement(trace, source),
        attributed_to=attribute_call(call) or "",
        disturbances=call.execution.disturbances,
        evidence=_evidence(call.execution.evidence),
        alternatives=tuple(_alternatives(call)),
    )


def finite(value: float | None) -> float | None:
    """Return a number where it is finite, as JSON requires; else None."""
    return value if value is not None and isfinite(value) else None


def _evidence(measurements: Mapping[str, Any]) -> str:
    return msgspec.json.encode(measurements).decode()[:MAX_EVIDENCE] if measurements else ""


def _alternatives(call: Call) -> Iterator[tuple[str, Ranking]]:
    """Yield the alternatives of the decision: callees, arguments, scopes, and the caller's end."""
    decision = call.decision
    for doubt in decision.read.doubts if decision.read is not None else ():
        title = f"element {doubt.number + 1} of {doubt.parameter}, as its caller read it"
        yield title, [(format_argument(element), chance) for element, chance in doubt.offered]
        if doubt.answer is not None:
            yield "as somebody answered", [(format_argument(doubt.answer), 1.0)]
    yield from _ranking("callee", decision.callees)
    for number, ranking in enumerate(decision.arguments, 1):
        yield from _ranking(f"argument {number}", ranking)
    yield from _ranking("scope", decision.scopes)
    if decision.end_probability is not None:
        yield "or to return", [("end of the caller", decision.end_probability)]
    if call.return_decision is not None and call.return_decision.end_probability is not None:
        yield "its own end", [("end", call.return_decision.end_probability)]
    for asked in (decision.asked, call.return_decision.asked if call.return_decision is not None else None):
        if asked is not None:
            yield "somebody was asked", [(format_option(each), each.probability) for each in asked.options]
            yield "and answered", [(format_option(asked.taken), 1.0)]
    if decision.answer is not None:
        yield "answered", [(_answer(decision.answer), decision.probability or 0.0)]


def _answer(answer: Answer) -> str:
    return "return" if answer.callee is None else format_invocation(answer.callee, answer.arguments)


def _ranking(title: str, ranking: traced.Ranking[Any]) -> Iterator[tuple[str, Ranking]]:
    if ranking:
        yield title, [(_alternative(each.value), each.probability) for each in ranking]


def _alternative(value: object) -> str:
    if value is None:
        return "none"
    return f"frames {value[0]} – {value[1]}" if isinstance(value, tuple) else str(value)


def motion(trace: Trace) -> list[Moment]:
    """Return the traced motion; without it, the states that calls were made in."""
    if trace.motions:
        return [(m.frame, m.time, m.gripper, m.closed, m.positions) for m in trace.motions]
    moments: list[Moment] = []
    positions: Mapping[str, Vector] = {}
    last = -1
    for call in trace.calls:
        if call.state != last:
            last, state = call.state, trace.states[call.state]
            moved = {name: p for name, p in state.positions.items() if positions.get(name) != p}
            positions = state.positions
            moments.append((call.frame, call.frame / 10, state.gripper, state.closed, moved))
    return moments
