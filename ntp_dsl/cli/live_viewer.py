"""A run that the rerun viewer shows as it happens."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from threading import Event, Thread
from time import perf_counter
from typing import Any

from ntp_dsl.cli.display import messages
from ntp_dsl.language.diagnostics.diagnostics import NtpError
from ntp_dsl.traces.export.rerun_recording import APPLICATION, SIDES, Entities
from ntp_dsl.traces.reader import read_trace

INTERVAL = 0.3  # [s] between two looks at the trace, at least
SHARE = 5  # times that a look took, between two of them: so that it costs the run little
PATIENCE = 10.0  # [s] that a viewer has for taking what is sent
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
    os.environ.setdefault("RUST_LOG", "off")  # else it writes to the terminal while it looks for the viewer
    import rerun  # of an extra, and slow to import

    address = HERE.format(viewer) if viewer.isdecimal() else viewer
    recording = rerun.RecordingStream(APPLICATION)
    try:
        recording.connect_grpc(address)
        recording.flush(timeout_sec=PATIENCE)
    except RuntimeError as error:
        raise NtpError(
            f"--viewer: no rerun viewer answers at {address}: start one with the command `rerun`, "
            "which prints its address"
        ) from error
    is_over = Event()
    thread = Thread(target=_follow, args=(trace, Entities(rerun, recording, SIDES[0]), is_over), daemon=True)
    thread.start()
    try:
        yield
    finally:
        is_over.set()
        thread.join()
        _close(recording)


def _follow(path: Path, entities: Entities, is_over: Event) -> None:
    """Send what is new in a trace, until the run is over."""
    size = cost = 0.0
    last = False
    while not last:
        last = is_over.wait(max(INTERVAL, SHARE * cost))
        if not path.is_file() or (now := path.stat().st_size) == size:
            continue
        size, started = now, perf_counter()
        with suppress(NtpError):  # its first line is being written
            entities.send(read_trace(path), path.parent)
        cost = perf_counter() - started


def _close(recording: Any) -> None:
    try:
        recording.flush(timeout_sec=PATIENCE)
    except RuntimeError:
        messages.print("the viewer has not taken all that was sent", style="yellow")
    recording.disconnect()
