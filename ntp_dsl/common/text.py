"""Text of unknown origin, made safe for a terminal."""

from __future__ import annotations


def printable(text: object) -> str:
    """Return the text with control characters escaped, so that a terminal cannot be commanded by it."""
    raw = str(text)
    return raw if raw.isprintable() else raw.encode("unicode_escape").decode("ascii")


def counted(number: int, noun: str) -> str:
    """Return a number and its noun: 1 primitive, 2 primitives."""
    return f"{number} {noun}" if number == 1 else f"{number} {noun}s"
