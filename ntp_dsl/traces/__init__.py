"""Execution traces: one schema for scripted and learned programs, written as it happens (docs/traces.md)."""

from ntp_dsl.traces.reader import parse_trace, read_trace
from ntp_dsl.traces.schema import FORMAT, ROOT, VERSION, Call, Trace, from_json, to_json
from ntp_dsl.traces.writer import TraceWriter

__all__ = [
    "FORMAT",
    "ROOT",
    "VERSION",
    "Call",
    "Trace",
    "TraceWriter",
    "from_json",
    "parse_trace",
    "read_trace",
    "to_json",
]
