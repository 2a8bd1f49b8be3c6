"""The library's own lines that a trace refers to, as the trace carries them."""

from __future__ import annotations

from ntp_dsl.traces.schema import Trace


def statement(trace: Trace, place: str) -> str:
    """Return the text at `file:line`, or nothing where the trace does not carry it."""
    file, _, line = place.rpartition(":")
    text = trace.header.sources.get(file)
    if text is None or not line.isdecimal():
        return ""
    rows = text.split("\n")
    return rows[int(line) - 1].strip() if 0 < int(line) <= len(rows) else ""
