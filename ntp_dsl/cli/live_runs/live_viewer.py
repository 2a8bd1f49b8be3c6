"""A run that the rerun viewer shows as it happens."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from threading import Event, Thread
from time import perf_counter

from ntp_dsl.cli.display import messages
from ntp_dsl.cli.live_runs.looking import pause
from ntp_dsl.language.diagnostics.diagnostics import NtpError
from ntp_dsl.traces.export.rerun_recording import Viewer
from ntp_dsl.traces.reader import read_trace

HERE = "rerun+http://127.0.0.1:{}/proxy"


@contextmanager
def streamed(trace: Path, viewer: str) -> Iterator[None]:
    """Send what a trace records to a viewer while it is written.

    Args:
        viewer: an address of rerun's, or a port of this machine.

    Raises:
        NtpError: no viewer answers there.
    """
    if not viewer.isdecimal() and "://" not in viewer:
        raise NtpError(
            f"--viewer: expected a port, such as 9876, or an address, such as {HERE.format(9876)}, "
            f"found '{viewer}'"
        )
    address = HERE.format(viewer) if viewer.isdecimal() else viewer
    try:
        shown = Viewer(address)
    except ConnectionError as error:
        raise NtpError(
            f"--viewer: no rerun viewer answers at {address}: start one with the command `rerun`, "
            "which prints its address"
        ) from error
    is_over = Event()
    thread = Thread(target=_follow, args=(trace, shown, is_over), daemon=True)
    thread.start()
    try:
        yield
    finally:
        is_over.set()
        thread.join()
        if not shown.close():
            messages.print("the viewer has not taken all that was sent", style="yellow")


def _follow(path: Path, viewer: Viewer, is_over: Event) -> None:
    """Send what is new in a trace, until the run is over."""
    size = cost = 0.0
    last = False
    while not last:
        last = is_over.wait(pause(cost))
        if not path.is_file() or (now := path.stat().st_size) == size:
            continue
        size, started = now, perf_counter()
        with suppress(NtpError, OSError, RuntimeError):  # a line is being written, or the viewer is busy
            viewer.send(read_trace(path), path.parent)
        cost = perf_counter() - started
