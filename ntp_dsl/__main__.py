"""The process of a command line: `ntp`, which is `python -m ntp_dsl`."""

from __future__ import annotations

import os
import signal
import sys
from typing import NoReturn


def main() -> NoReturn:
    """Run the command line of this process; the entry point of `ntp`."""
    status = 130
    try:
        signal.signal(signal.SIGTERM, signal.default_int_handler)
        _open_streams()
        from ntp_dsl.cli.app import run  # here, so that Ctrl-C meanwhile is no traceback

        status = _written(run(sys.argv[1:]))
    except KeyboardInterrupt:
        print("interrupted", file=sys.stderr)
    for each in (signal.SIGINT, signal.SIGTERM):
        signal.signal(each, signal.SIG_IGN)  # the end has begun
    sys.exit(status)


def _open_streams() -> None:
    """Print what an encoding lacks with replacements, and nothing where a stream is closed."""
    sys.stdout = sys.stdout or open(os.devnull, "w")
    sys.stderr = sys.stderr or open(os.devnull, "w")
    for stream in (sys.stdout, sys.stderr):
        stream.reconfigure(errors="replace")  # type: ignore[union-attr]


def _written(status: int) -> int:
    """Return the exit status, when standard output has taken everything."""
    try:
        sys.stdout.flush()
    except OSError as error:
        if isinstance(error, BrokenPipeError):
            status = 141
        elif status == 0:
            print(f"standard output: {error.strerror}", file=sys.stderr)
            status = 2
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())  # what is left goes nowhere
    return status


if __name__ == "__main__":
    main()
