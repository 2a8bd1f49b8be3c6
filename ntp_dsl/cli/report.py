"""What was found in a text, for people: in colour on a terminal, plain everywhere else."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterable, Sequence
from typing import TextIO

from ntp_dsl.language.diagnostics.diagnostics import Diagnostic
from ntp_dsl.language.diagnostics.rendering import Line, Sources, Style, plain, render

COLOURS = {
    Style.STRONG: "bold",
    Style.FRAME: "bold blue",
    Style.ERROR: "bold red",
    Style.WARNING: "bold yellow",
    Style.NOTE: "bold cyan",
    Style.HELP: "bold green",
    Style.ADDED: "green",
    Style.REMOVED: "red",
}


def print_diagnostics(
    diagnostics: Iterable[Diagnostic], sources: Sources, stream: TextIO | None = None
) -> None:
    """Each with excerpts of its places, and an empty line after it."""
    for diagnostic in diagnostics:
        print_lines([*render(diagnostic, sources), ()], stream)


def print_lines(lines: Sequence[Line], stream: TextIO | None = None) -> None:
    """Lines with styles, in colour if the stream is a terminal whose owner did not say no."""
    stream = stream or sys.stdout
    if not wants_colour(stream):
        print(plain(lines), file=stream)
        return
    from rich.console import Console
    from rich.text import Text

    console = Console(file=stream, highlight=False, soft_wrap=True)
    for line in lines:
        console.print(Text.assemble(*((text, COLOURS.get(style, "")) for text, style in line)))


def wants_colour(stream: TextIO) -> bool:
    """Whether it is a terminal that shows colour; see no-color.org."""
    return stream.isatty() and not os.environ.get("NO_COLOR") and os.environ.get("TERM") != "dumb"


def summary(diagnostics: Sequence[Diagnostic]) -> str:
    """How many of each kind, and how many can be mended: "2 mistakes found, 1 warning"."""
    counts = {word: sum(each.severity == word for each in diagnostics) for word in COUNTED}
    told = [_count(counts[word], noun) for word, noun in COUNTED.items() if counts[word]]
    if counts["error"]:
        told[0] += " found"
    return ", ".join(told)


COUNTED = {"error": "mistake", "warning": "warning", "note": "note"}


def _count(number: int, noun: str) -> str:
    return f"{number} {noun}{'s' * (number != 1)}"
