"""The process around a command line: its streams, and the signals that end it."""

from __future__ import annotations

import os
import signal
import sys
from collections.abc import Sequence

from ntp_dsl.cli.app import MISUSE, UNREAD, run
from ntp_dsl.common.garbage import collect_seldom
from ntp_dsl.common.signals import ENDING, ignore


def run_process(words: Sequence[str]) -> int:
    """Run a command line, and return its exit status when standard output has taken everything."""
    for each in (signal.SIGTERM, signal.SIGHUP):
        if signal.getsignal(each) is not signal.SIG_IGN:  # as under nohup
            signal.signal(each, signal.default_int_handler)
    _open_streams()
    collect_seldom()
    status = _flushed(run(words))
    for each in ENDING:
        signal.signal(each, ignore)  # the end has begun
    return status


def _open_streams() -> None:
    """Print what an encoding lacks with replacements, and nothing where a stream is closed."""
    sys.stdout = sys.stdout or open(os.devnull, "w")
    sys.stderr = sys.stderr or open(os.devnull, "w")
    for stream in (sys.stdout, sys.stderr):
        stream.reconfigure(errors="replace")  # type: ignore[union-attr]


def _flushed(status: int) -> int:
    try:
        sys.stdout.flush()
    except OSError as error:
        if isinstance(error, BrokenPipeError):
            status = UNREAD
        elif status == 0:
            print(f"standard output: {error.strerror}", file=sys.stderr)
            status = MISUSE
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())  # what is left goes nowhere
    return status
