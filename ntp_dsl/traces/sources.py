"""The library's own lines that a trace refers to, as the trace carries them."""

from __future__ import annotations

from ntp_dsl.traces.schema import Trace


def statement(trace: Trace, place: str) -> str:
    """The text at `file:line`, or nothing where the trace does not carry it."""
    file, _, line = place.rpartition(":")
    sources = trace.header.get("sources")
    text = sources.get(file) if isinstance(sources, dict) else None
    if not isinstance(text, str) or not line.isdecimal():
        return ""
    rows = text.split("\n")
    return rows[int(line) - 1].strip() if 0 < int(line) <= len(rows) else ""
