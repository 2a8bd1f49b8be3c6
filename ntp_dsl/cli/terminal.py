"""What is typed at the terminal."""

from __future__ import annotations

import sys


def read_line() -> str:
    """Return the next line that is typed; an empty text where there are no more."""
    return sys.stdin.readline() if sys.stdin is not None else ""


def has_typist() -> bool:
    """Return whether somebody can type."""
    return sys.stdin is not None and sys.stdin.isatty()
