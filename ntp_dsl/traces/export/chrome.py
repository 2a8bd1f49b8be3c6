"""Traces in Chrome's trace event format, which Perfetto, speedscope and others open.

Each trace is a process; its calls are nested slices.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

from ntp_dsl.traces.export.slices import details, slices
from ntp_dsl.traces.phrases import format_call, headline
from ntp_dsl.traces.trace import Trace

Event = dict[str, Any]


def document(traces: Sequence[Trace]) -> dict[str, Any]:
    """Return the format's JSON object; processes are numbered from 1."""
    events = [event for number, trace in enumerate(traces, 1) for event in _events(trace, number)]
    return {"traceEvents": events, "displayTimeUnit": "ms"}


def _events(trace: Trace, process: int) -> Iterator[Event]:
    place = {"pid": process, "tid": 1}
    yield {"ph": "M", "name": "process_name", "args": {"name": headline(trace.header)}, **place}
    yield {"ph": "M", "name": "thread_name", "args": {"name": "calls"}, **place}
    for each in slices(trace):
        times = {"ph": "X", "ts": each.begin, "dur": each.length, **place}
        if each.part:
            yield {"name": each.part, "cat": each.part, **times}
        else:
            call = each.call
            yield {"name": format_call(call), "cat": call.kind, "args": details(call), **times}
