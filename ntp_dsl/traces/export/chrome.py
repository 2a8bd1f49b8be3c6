"""Traces in Chrome's trace event format, which Perfetto, speedscope and others open.

Each trace is a process; its calls are slices one in another, and in them stand the times of deciding,
planning and moving. The clock is of those times laid end to end: what else the world took is not counted.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from ntp_dsl.traces.phrases import headline, in_words
from ntp_dsl.traces.schema import Call, Trace

Event = dict[str, Any]
LEAST = 1  # [µs] of a slice: what takes no time would not be seen


def document(traces: Sequence[Trace]) -> dict[str, Any]:
    """Return one JSON object, as the format has it; processes are numbered from 1."""
    events = [event for number, trace in enumerate(traces, 1) for event in _events(trace, number)]
    return {"traceEvents": events, "displayTimeUnit": "ms"}


def _events(trace: Trace, process: int) -> list[Event]:
    """In the order of beginning: of two slices of one span, readers take the first for the outer one."""
    place = {"pid": process, "tid": 1}
    events: list[Event] = [
        {"ph": "M", "name": "process_name", "args": {"name": headline(trace)}, **place},
        {"ph": "M", "name": "thread_name", "args": {"name": "calls"}, **place},
    ]
    clock = 0
    running: list[Event] = []
    for call, returns in trace.events():
        spans = _before_return(call) if returns else {"decide": call.decision.seconds}
        for name, spent in spans.items():
            if spent:
                length = max(LEAST, round(1e6 * spent))
                events.append({"ph": "X", "name": name, "cat": name, "ts": clock, "dur": length, **place})
                clock += length
        if returns:
            clock = _ended(running.pop(), clock)
        else:
            running.append(_slice(call, clock) | place)
            events.append(running[-1])
    for slice in reversed(running):  # of a trace that was cut off
        clock = _ended(slice, clock)
    return events


def _ended(slice: Event, clock: int) -> int:
    """The clock, moved on where nothing took time."""
    slice["dur"] = max(LEAST, clock - slice["ts"])
    return int(slice["ts"] + slice["dur"])


def _before_return(call: Call) -> Mapping[str, float]:
    if call.is_program:
        return {"decide": call.ending.seconds if call.ending else 0.0}
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
    told = {name: value for name, value in facts.items() if value not in (None, [])}
    return {"ph": "X", "name": in_words(call), "cat": call.kind, "ts": begin, "dur": 0, "args": told}
