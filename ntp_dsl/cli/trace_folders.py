"""Folders of traces: which files are traces, and what each came to."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from ntp_dsl.language.diagnostics.diagnostics import NtpError
from ntp_dsl.traces.reader import read_trace

TRACES = "*.trace.jsonl"


def traces_in(folder: Path) -> list[Path]:
    """Return the traces of a folder in order. Raises `NtpError` where there are none."""
    found = sorted(folder.glob(TRACES))
    if not found:
        raise NtpError(f"{folder}: contains no traces ({TRACES}); `ntp eval … --out DIR` writes them")
    return found


def summary(file: Path) -> dict[str, Any]:
    """Return a trace's name, number of calls and ending; of a damaged one, that it is none."""
    try:
        trace = read_trace(file)
    except NtpError:
        return {"file": file.name, "calls": 0, "ending": "unreadable"}
    ending = "cut off" if trace.end is None else str(trace.end.ending)
    return {"file": file.name, "calls": len(trace.calls), "ending": ending}
