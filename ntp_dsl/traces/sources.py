"""Lines of the library's source, from the copy that a trace carries."""

from __future__ import annotations

from ntp_dsl.traces.schema import Trace


def statement(trace: Trace, place: str) -> str:
    """Return the text at `file:line`, or an empty string where the trace lacks it."""
    file, _, line = place.rpartition(":")
    text = trace.header.sources.get(file)
    if text is None or not line.isdecimal():
        return ""
    rows = text.split("\n")
    return rows[int(line) - 1].strip() if 0 < int(line) <= len(rows) else ""
