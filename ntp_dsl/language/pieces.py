"""From text to pieces, cut where a line begins at the margin, so that mistakes stay apart."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from ntp_dsl.language.diagnostics import Diagnostic, Fix, nearest
from ntp_dsl.language.syntax import Span

KEYWORDS = (
    "library", "use", "type", "enum", "record", "constant", "predicate", "api", "program", "task",
)  # fmt: skip
MARKS = re.compile(r'"""|#|[()\[\]]')
WORD = re.compile(r"[A-Za-z_][A-Za-z0-9_]*")
# Inside an open docstring, only what can be nothing else than a declaration counts as one.
HEADER = re.compile(rf"(?:{'|'.join(KEYWORDS)})[ \t]+[A-Za-z_][A-Za-z0-9_]*[ \t]*[(:]")
PARTNERS = {"(": ")", "[": "]"}


@dataclass(frozen=True)
class Piece:
    """The text of one declaration, and the line at which it begins."""

    text: str
    line: int
    path: Path | None

    @property
    def keyword(self) -> str:
        """The first word, or nothing if the piece begins with something else."""
        word = WORD.match(self.text)
        return word.group() if word else ""

    def span(self, line: int, column: int, width: int = 1) -> Span:
        """A stretch of one line; `line` counts from one within the piece."""
        line += self.line - 1
        return Span(self.path, line, column, line, column + width)

    def at(self, offset: int, width: int = 1) -> Span:
        """The place of a character of the piece's text."""
        before = self.text[:offset]
        return self.span(before.count("\n") + 1, offset - (before.rfind("\n") + 1) + 1, width)


def cut(text: str, path: Path | None) -> list[Piece]:
    """Every line at the margin begins a piece, unless a bracket or a docstring is open there."""
    starts: list[int] = []
    lines = text.split("\n")
    depth, quoted = 0, False
    for index, line in enumerate(lines):
        stray = not starts and line.strip() and not line.lstrip().startswith("#")
        if stray or _begins(line, depth, quoted, lines[starts[-1]] if starts else ""):
            starts.append(index)
            depth, quoted = 0, False
        depth, quoted = _marks(line, depth, quoted)
    ends = [*starts, len(lines)][1:]
    return [
        Piece("\n".join(lines[start:end]).rstrip() + "\n", start + 1, path)
        for start, end in zip(starts, ends, strict=True)
    ]


def _begins(line: str, depth: int, quoted: bool, previous: str) -> bool:
    if quoted:
        return HEADER.match(line) is not None
    if not line[:1].strip() or line.startswith("#"):
        return False
    if line.startswith('"""'):
        return WORD.match(previous) is None or not previous.startswith("library")
    word = WORD.match(line)
    return depth == 0 or (word is not None and word.group() in KEYWORDS)


def _marks(line: str, depth: int, quoted: bool) -> tuple[int, bool]:
    """How many brackets, and whether a docstring, are open at the end of the line."""
    for match in MARKS.finditer(line):
        mark = match.group()
        if mark == '"""':
            quoted = not quoted
        elif quoted:
            continue
        elif mark == "#":
            break
        else:
            depth = depth + 1 if mark in PARTNERS else max(0, depth - 1)
    return depth, quoted


def _open_marks(text: str) -> Iterator[tuple[str, int]]:
    """Brackets and open docstrings with their offsets; comments and docstrings are skipped."""
    position = 0
    while match := MARKS.search(text, position):
        mark, position = match.group(), match.end()
        if mark == "#":
            position = text.find("\n", position) % (len(text) + 1)
        elif mark == '"""':
            end = text.find('"""', position)
            if end < 0:
                yield mark, match.start()
                return
            position = end + 3
        else:
            yield mark, match.start()


def unbalanced(piece: Piece) -> Iterator[Diagnostic]:
    """The first bracket or docstring that has no partner."""
    stack: list[tuple[str, int]] = []
    for mark, offset in _open_marks(piece.text):
        if mark == '"""':
            yield Diagnostic("E004", 'this docstring is never closed by """', piece.at(offset, 3))
            return
        if mark in PARTNERS:
            stack.append((mark, offset))
        elif not stack or PARTNERS[stack[-1][0]] != mark:
            message = f"nothing was opened that this '{mark}' closes"
            yield Diagnostic("E003", message, piece.at(offset))
            return
        else:
            stack.pop()
    for mark, offset in stack[:1]:
        message = f"this '{mark}' is never closed by a '{PARTNERS[mark]}'"
        yield Diagnostic("E003", message, piece.at(offset))


def misspelt(piece: Piece) -> Diagnostic:
    """For a piece that begins with none of the keywords."""
    found = piece.keyword
    span = piece.at(0, max(1, len(found)))
    help = f"a line at the margin begins with one of: {', '.join(KEYWORDS)}"
    meant = nearest(found, KEYWORDS) if found else None
    if meant:
        message = f"nothing begins with '{found}'; did you mean '{meant}'?"
        return Diagnostic("E002", message, span, help=help, fix=Fix(span, meant))
    message = f"no declaration begins with {found or piece.text[0]!r}"
    if piece.text[0].isspace():
        message = "this line is indented, and there is no declaration above it"
    return Diagnostic("E002", message, span, help=help)
