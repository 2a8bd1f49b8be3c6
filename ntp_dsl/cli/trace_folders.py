"""Folders of traces: which files are traces, and what each came to."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from ntp_dsl.cli.display import messages
from ntp_dsl.common.text import counted
from ntp_dsl.language.diagnostics.diagnostics import NtpError
from ntp_dsl.traces.reader import read_trace
from ntp_dsl.traces.schema import Ending
from ntp_dsl.traces.trace import Trace

TRACES = "*.trace.jsonl"
UNREADABLE = "unreadable"  # in place of how a trace ends


def traces_in(folder: Path) -> list[Path]:
    """Return the traces of a folder in order. Raises `NtpError` where there are none."""
    found = sorted(folder.glob(TRACES))
    if not found:
        raise NtpError(f"{folder}: contains no traces ({TRACES}); `ntp eval … --out DIR` writes them")
    return found


def pairs(first: Path, second: Path) -> list[tuple[Path, Path]]:
    """Return the traces that two folders have under the same names, and say which have no counterpart.

    Of two files, they are the only pair. Raises `NtpError` where there is no pair.
    """
    if first.is_dir() != second.is_dir():
        raise NtpError(f"{first} and {second}: expected two traces, or two folders")
    if not first.is_dir():
        return [(first, second)]
    a, b = ({path.name for path in traces_in(folder)} for folder in (first, second))
    both = sorted(a & b)
    if not both:
        raise NtpError(f"{first} and {second} have no traces of the same names")
    for folder, alone in ((first, len(a - b)), (second, len(b - a))):
        if alone:
            messages.print(f"{counted(alone, 'trace')} of {folder} without a counterpart: left out")
    return [(first / name, second / name) for name in both]


def reference(file: Path, against: Path | None) -> Trace | None:
    """Return the trace of the same name in another folder; None, and a message, where there is none to read.

    Raises `NtpError` where the folder is none.
    """
    if against is None:
        return None
    if not against.is_dir():
        raise NtpError(f"--against: {against} is no folder")
    other = against / file.name
    if not other.is_file():
        messages.print(f"{other} is not there: {file.name} is not compared")
        return None
    return readable(other)


def readable(file: Path) -> Trace | None:
    """Return a trace; None, and a message, where it cannot be read."""
    try:
        return read_trace(file)
    except NtpError as error:
        messages.print(f"skipped {error}", style="yellow")
        return None


def first_failed(folder: Path) -> Path:
    """Return the first trace of a folder that failed, or else the first, and say which.

    Raises `NtpError` where there are none.
    """
    summaries = {file: summary(file) for file in traces_in(folder)}
    files = [file for file, each in summaries.items() if each.ending != UNREADABLE]
    if not files:
        raise NtpError(f"{folder}: none of its traces can be read")
    if lost := len(summaries) - len(files):
        messages.print(f"{counted(lost, 'trace')} cannot be read: left out", style="yellow")
    failed = [file for file in files if summaries[file].has_failed]
    chosen = failed[0] if failed else files[0]
    first = f"the first of {len(failed)} that failed" if failed else "none failed, so the first"
    messages.print(f"{chosen.name}: {first}, of {counted(len(files), 'trace')}")
    return chosen


@dataclass(frozen=True)
class Summary:
    """A trace in a line."""

    file: str
    calls: int
    ending: str
    success: bool | None = None  # None where it was not judged
    attributed_to: str = ""  # of a failure, as the next
    verdict: str = ""

    @property
    def has_failed(self) -> bool:
        """Whether it was judged a failure; of one that was not judged, whether it did not end by itself."""
        return self.ending != Ending.DONE if self.success is None else not self.success


def summary(file: Path) -> Summary:
    """Return a trace's name, number of calls and ending; of a damaged one, that it is none."""
    try:
        trace = read_trace(file)
    except NtpError:
        return Summary(file.name, 0, UNREADABLE)
    end, calls = trace.end, len(trace.calls)
    if end is None:
        return Summary(file.name, calls, "cut off")
    return Summary(file.name, calls, str(end.ending), end.success, str(end.attributed_to or ""), end.verdict)
