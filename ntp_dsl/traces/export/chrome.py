"""Traces in Chrome's trace event format, which Perfetto, speedscope and others open.

Each trace is a process; its calls are nested slices that contain the times of deciding, planning and moving.
The clock runs through those times alone: other time that the world took is not counted.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from ntp_dsl.traces.phrases import format_call, headline
from ntp_dsl.traces.schema import Call
from ntp_dsl.traces.trace import Trace

Event = dict[str, Any]
MIN_DURATION = 1  # [µs] of a slice, so that it is visible


def document(traces: Sequence[Trace]) -> dict[str, Any]:
    """Return the format's JSON object; processes are numbered from 1."""
    events = [event for number, trace in enumerate(traces, 1) for event in _events(trace, number)]
    return {"traceEvents": events, "displayTimeUnit": "ms"}


def _events(trace: Trace, process: int) -> list[Event]:
    """Return the events by begin: of two slices with one span, readers take the first as the outer."""
    place = {"pid": process, "tid": 1}
    events: list[Event] = [
        {"ph": "M", "name": "process_name", "args": {"name": headline(trace.header)}, **place},
        {"ph": "M", "name": "thread_name", "args": {"name": "calls"}, **place},
    ]
    clock = 0
    running: list[Event] = []
    for call, returns in trace.events():
        spans = _before_return(call) if returns else {"decide": call.decision.seconds}
        for name, spent in spans.items():
            if spent:
                length = max(MIN_DURATION, round(1e6 * spent))
                events.append({"ph": "X", "name": name, "cat": name, "ts": clock, "dur": length, **place})
                clock += length
        if returns:
            clock = _close(running.pop(), clock)
        else:
            running.append(_slice(call, clock) | place)
            events.append(running[-1])
    for slice in reversed(running):  # of a trace that was cut off
        clock = _close(slice, clock)
    return events


def _close(slice: Event, clock: int) -> int:
    """Set the duration of a slice, at least the minimum, and return the clock at its end."""
    slice["dur"] = max(MIN_DURATION, clock - slice["ts"])
    return int(slice["ts"] + slice["dur"])


def _before_return(call: Call) -> Mapping[str, float]:
    if call.is_program:
        return {"decide": call.return_decision.seconds if call.return_decision else 0.0}
    return {"plan": call.execution.planning, "move": call.execution.moving}


def _slice(call: Call, begin: int) -> Event:
    facts = {
        "outcome": call.outcome or "cut off",
        "scope": call.scope,
        "probability": call.decision.probability,
        "source": call.decision.source or None,
        "frame": call.frame,
        "disturbances": list(call.execution.disturbances),
    }
    details = {name: value for name, value in facts.items() if value not in (None, [])}
    return {"ph": "X", "name": format_call(call), "cat": call.kind, "ts": begin, "dur": 0, "args": details}
