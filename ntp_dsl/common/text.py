"""Text of unknown origin, made safe for a terminal."""

from __future__ import annotations

from collections.abc import Sequence

MAX_NAME = 200  # [characters] of a name in a message


def printable(text: object) -> str:
    """Return the text with control characters escaped, so that a terminal cannot be commanded by it."""
    raw = str(text)
    return raw if raw.isprintable() else raw.encode("unicode_escape").decode("ascii")


def counted(number: int, noun: str) -> str:
    """Return a number and its noun: 1 primitive, 2 primitives."""
    return f"{number} {noun}" if number == 1 else f"{number} {noun}s"


def shortened(text: object) -> str:
    """Return the text printable, and cut where it is too long for a message."""
    whole = printable(text)
    return whole if len(whole) <= MAX_NAME else f"{whole[:MAX_NAME]}..."


def listed(facts: Sequence[object], most: int) -> str:
    """Return the first facts as text, and how many there are besides."""
    more = f" and {len(facts) - most} more" if len(facts) > most else ""
    return ", ".join(map(str, facts[:most])) + more


def enumerated(texts: Sequence[str]) -> str:
    """Return texts as an enumeration: a, b and c."""
    if len(texts) <= 1:
        return "".join(texts)
    return f"{', '.join(texts[:-1])} and {texts[-1]}"
