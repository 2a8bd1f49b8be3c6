"""The signals that end a command: SIGINT (Ctrl-C) and SIGTERM, which raise `KeyboardInterrupt`."""

from __future__ import annotations

import signal
from collections.abc import Iterator
from contextlib import contextmanager
from threading import current_thread, main_thread

ENDING = (signal.SIGINT, signal.SIGTERM)


def ignore(*_: object) -> None:
    """Ignore a signal; Python warns of one that comes while `SIG_IGN` is set."""


@contextmanager
def deferred() -> Iterator[None]:
    """Raise `KeyboardInterrupt` afterwards where a signal comes meanwhile; in the main thread only."""
    if current_thread() is not main_thread():
        yield
        return
    received: list[int] = []
    earlier = [signal.signal(each, lambda number, _: received.append(number)) for each in ENDING]
    try:
        yield
    finally:
        for each, handler in zip(ENDING, earlier, strict=True):
            signal.signal(each, handler)
    if received:
        raise KeyboardInterrupt


@contextmanager
def uninterrupted() -> Iterator[None]:
    """Ignore the signals, for the second in which an answer is printed."""
    earlier = [signal.signal(each, ignore) for each in ENDING]
    try:
        yield
    finally:
        for each, handler in zip(ENDING, earlier, strict=True):
            signal.signal(each, handler)
