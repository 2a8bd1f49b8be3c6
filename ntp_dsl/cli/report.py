"""Diagnostics as text for people: in colour on a terminal, plain elsewhere."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import TextIO

from ntp_dsl.language.diagnostics.diagnostics import Diagnostic
from ntp_dsl.language.diagnostics.rendering import (
    Line,
    Sources,
    Style,
    changed_lines,
    plain,
    render,
    shown_path,
)

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
SEVERITIES = ("error", "warning", "note")


def print_diagnostics(
    diagnostics: Iterable[Diagnostic], sources: Sources, stream: TextIO | None = None
) -> None:
    """Print each diagnostic with excerpts of the source, followed by an empty line."""
    for diagnostic in diagnostics:
        print_lines([*render(diagnostic, sources), ()], stream)


def print_lines(lines: Sequence[Line], stream: TextIO | None = None) -> None:
    """Print styled lines, in colour where the stream is a terminal that shows it."""
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
    """Whether the stream is a terminal that shows colour; see no-color.org."""
    return stream.isatty() and not os.environ.get("NO_COLOR") and os.environ.get("TERM") != "dumb"


def summary(diagnostics: Sequence[Diagnostic]) -> str:
    """Return the number of diagnostics of each kind, such as "2 errors found, 1 warning"."""
    counts = {severity: sum(each.severity == severity for each in diagnostics) for severity in SEVERITIES}
    parts = [_count(count, severity) for severity, count in counts.items() if count]
    if counts["error"]:
        parts[0] += " found"
    return ", ".join(parts)


def _count(number: int, noun: str) -> str:
    return f"{number} {noun}{'s' * (number != 1)}"


def difference(path: Path, before: str, after: str) -> list[Line]:
    """Return the lines of a file that differ, with their numbers."""
    changes = list(changed_lines(before, after))
    margin = max(len(str(number)) for number, _, _ in changes)
    lines: list[Line] = [((f"{shown_path(path)}:", Style.STRONG),)]
    for number, sign, row in changes:
        style = Style.ADDED if sign == "+" else Style.REMOVED
        text = row.rstrip("\r")
        lines.append(((f" {number:>{margin}} ", Style.FRAME), (f"{sign} {text}", style)))
    return [*lines, ()]
