"""From a diagnostic to the lines that a person reads: the place, carets, related places, the fix."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from difflib import SequenceMatcher
from enum import StrEnum
from pathlib import Path
from unicodedata import category, combining, east_asian_width

from ntp_dsl.language.diagnostics.apply_fixes import apply_fixes
from ntp_dsl.language.diagnostics.diagnostics import Diagnostic
from ntp_dsl.language.syntax.nodes import Span

Sources = Mapping[Path | None, str]


class Style(StrEnum):
    """The role of a segment of a line; the colours are up to the printer."""

    PLAIN = "plain"
    STRONG = "strong"
    FRAME = "frame"
    ERROR = "error"
    WARNING = "warning"
    NOTE = "note"
    HELP = "help"
    ADDED = "added"
    REMOVED = "removed"


Line = tuple[tuple[str, Style], ...]


@dataclass(frozen=True)
class _Mark:
    """A stretch of source to underline, and its label."""

    span: Span
    label: str
    stroke: str
    style: Style


def plain(lines: Iterable[Line]) -> str:
    """Return the lines as text, without styles."""
    return "\n".join("".join(text for text, _ in line) for line in lines)


def render(diagnostic: Diagnostic, sources: Sources) -> list[Line]:
    """Return the diagnostic as lines, with an excerpt of every place that it refers to."""
    style = Style(diagnostic.severity)
    title = (f"{diagnostic.severity}[{diagnostic.code}]", style)
    lines: list[Line] = [(title, (f": {_visible(diagnostic.message)}", Style.STRONG))]
    marks = [_Mark(diagnostic.span, "", "^", style)]
    marks += [_Mark(note.span, note.message, "-", Style.NOTE) for note in diagnostic.notes]
    placed = [mark for mark in marks if mark.span.line]
    margin = max([len(str(mark.span.line)) for mark in placed] or [1])
    for path in dict.fromkeys(mark.span.path for mark in placed):
        here = [mark for mark in placed if mark.span.path == path]
        arrow = "-->" if path == diagnostic.span.path else ":::"
        if arrow == ":::":
            lines.append(_framed("", margin))
        place = f" {shown(here[0].span)}"
        lines.append(((" " * margin + f" {arrow}", Style.FRAME), (place, Style.PLAIN)))
        lines += _excerpt(here, sources.get(path), margin)
    return lines + _remarks(diagnostic, sources, margin)


def shown(span: Span) -> str:
    """Return the place, relative to the working directory."""
    return f"{shown_path(span.path)}:{span.line}:{span.column}" if span.path else str(span)


def shown_path(path: Path) -> str:
    """Return the path, relative to the working directory if it lies in it."""
    if path.is_absolute() and path.is_relative_to(Path.cwd()):
        return str(path.relative_to(Path.cwd()))
    return str(path)


def _remarks(diagnostic: Diagnostic, sources: Sources, margin: int) -> list[Line]:
    """Return what has no place in the text: notes, help, and the fix."""
    lines = [
        _remark("note", Style.NOTE, note.message, margin) for note in diagnostic.notes if not note.span.line
    ]
    if diagnostic.help:
        lines.append(_remark("help", Style.HELP, diagnostic.help, margin))
    lines += _proposal(diagnostic, sources, margin)
    return [_framed("", margin), *lines] if lines else []


def _remark(word: str, style: Style, message: str, margin: int) -> Line:
    frame = " " * margin + "  = "
    return ((frame, Style.FRAME), (f"{word}: ", style), (_visible(message), Style.PLAIN))


def _excerpt(marks: Sequence[_Mark], source: str | None, margin: int) -> list[Line]:
    """Return the marked lines, each once, in their order; lines in between are left out."""
    rows = source.split("\n") if source is not None else []
    lines: list[Line] = []
    numbers = sorted({mark.span.line for mark in marks if mark.span.line <= len(rows)})
    for before, number in zip([None, *numbers], numbers, strict=False):
        if before is None:
            lines.append(_framed("", margin))
        elif number == before + 2:
            lines.append(_framed(before + 1, margin, (_visible(rows[before]), Style.PLAIN)))
        elif number > before + 2:
            lines.append((("...", Style.FRAME),))
        row = rows[number - 1]
        lines.append(_framed(number, margin, (_visible(row), Style.PLAIN)))
        for mark in marks:
            if mark.span.line == number:
                lines.append(_framed("", margin, *_underline(row, mark)))
    return lines


def _framed(number: int | str, margin: int, *segments: tuple[str, Style]) -> Line:
    gutter = f" {number:>{margin}} |"
    if not segments or not segments[-1][0]:
        return ((gutter, Style.FRAME),)
    return ((f"{gutter} ", Style.FRAME), *segments)


def _underline(row: str, mark: _Mark) -> Iterator[tuple[str, Style]]:
    span = mark.span
    begin = min(span.column - 1, len(row))
    end = span.end_column - 1 if span.end_line == span.line else len(row)
    yield "".join(map(_blank, row[:begin])), Style.PLAIN
    width = sum(len(_blank(letter)) for letter in row[begin:end])
    yield mark.stroke * max(1, width), mark.style
    if mark.label:
        yield f" {mark.label}", mark.style


def _blank(letter: str) -> str:
    """Return blanks as wide as the letter; tabs are copied, so that the caret stands below its place."""
    if letter == "\t":
        return letter
    return "" if combining(letter) else "  " if east_asian_width(letter) in "WF" else " "


def _visible(text: str) -> str:
    """Replace characters that would control a terminal."""
    return "".join("�" if category(c) == "Cc" and c != "\t" else c for c in text)


def _proposal(diagnostic: Diagnostic, sources: Sources, margin: int) -> list[Line]:
    """Return the lines that the fix would change; none where the message says it already."""
    fix = diagnostic.fix
    if fix is None or not fix.also and f"'{fix.replacement}'" in diagnostic.message:
        return []
    source = sources.get(fix.span.path)
    if source is None:
        return []
    fixed = apply_fixes(source, [fix], fix.span.path)
    changes = list(changed_lines(source, fixed))
    if not changes:
        return []
    word, words = "fix", "`ntp check --fix` would write"
    if not fix.certain:
        word, words = "offer", "perhaps this is meant; `ntp check --fix` leaves it to you"
    lines = [_remark(word, Style.HELP, words, margin)]
    for number, sign, row in changes:
        style = Style.ADDED if sign == "+" else Style.REMOVED
        gutter = f" {number:>{margin}} "
        lines.append(((gutter, Style.FRAME), (f"{sign} {_visible(row)}", style)))
    return lines


def changed_lines(before: str, after: str) -> Iterator[tuple[int, str, str]]:
    """Yield the lines that differ: the number of each in its own text, `-` or `+`, and the line."""
    old, new = before.split("\n"), after.split("\n")
    head = 0  # the common beginning and end are cut off first: most texts differ in one line
    while head < min(len(old), len(new)) and old[head] == new[head]:
        head += 1
    tail = 0
    while tail < min(len(old), len(new)) - head and old[-1 - tail] == new[-1 - tail]:
        tail += 1
    old, new = old[head : len(old) - tail], new[head : len(new) - tail]
    for tag, i1, i2, j1, j2 in SequenceMatcher(None, old, new, autojunk=False).get_opcodes():
        if tag != "equal":
            yield from ((head + i + 1, "-", old[i]) for i in range(i1, i2))
            yield from ((head + j + 1, "+", new[j]) for j in range(j1, j2))
