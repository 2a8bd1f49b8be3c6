"""The demonstration that lies beside a trace."""

from __future__ import annotations

from pathlib import Path

from ntp_dsl.cli.display import messages
from ntp_dsl.demonstrations.demonstration import Demonstration, check_objects
from ntp_dsl.demonstrations.demonstration_files import read_demonstration
from ntp_dsl.language.diagnostics.diagnostics import NtpError
from ntp_dsl.traces.trace import Trace


def demonstration_file(trace: Trace, file: Path) -> Path | None:
    """Return the demonstration that a trace names, where it lies beside it."""
    reference = trace.header.demonstration
    if reference is None or not reference.file:
        return None
    path = file.parent / Path(reference.file).name
    return path if path.is_file() else None


def demonstration_beside(trace: Trace, file: Path) -> Demonstration | None:
    """Return the demonstration that lies beside a trace; None, and a message, where it cannot be shown."""
    path = demonstration_file(trace, file)
    if path is None:
        return None
    try:
        shown = read_demonstration(path)
        if trace.header.objects:
            check_objects(shown, trace.header.objects)
    except NtpError as error:
        messages.print(f"{path} is not shown: {error}", style="yellow")
        return None
    return shown
