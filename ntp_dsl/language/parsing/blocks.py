"""From text to pieces, cut where a line begins at the margin, so that mistakes stay apart."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

from ntp_dsl.language.diagnostics.diagnostics import Diagnostic, Edit, Fix, nearest
from ntp_dsl.language.syntax.nodes import Span

# What each keyword declares, by the namespace that it belongs to; the first two declare nothing.
SPACES = {
    "library": "", "use": "", "type": "type", "enum": "type", "record": "type", "constant": "value",
    "predicate": "predicate", "api": "call", "program": "call", "task": "task",
}  # fmt: skip
KEYWORDS = tuple(SPACES)
# What other languages say for them.
ELSEWHERE = {
    "import": "use", "include": "use", "from": "use", "using": "use", "require": "use", "open": "use",
    "module": "library", "package": "library", "domain": "library", "namespace": "library",
    "class": "type", "object": "type", "struct": "record", "tuple": "record", "dataclass": "record",
    "enumeration": "enum", "const": "constant", "fluent": "predicate", "relation": "predicate",
    "property": "predicate", "skill": "api", "action": "api", "primitive": "api", "extern": "api",
    "def": "program", "fn": "program", "fun": "program", "func": "program", "function": "program",
    "proc": "program", "procedure": "program", "method": "program", "routine": "program",
    "problem": "task", "goal": "task", "experiment": "task", "test": "task",
}  # fmt: skip
MARKS = re.compile(r'"""|"[^"\n]*"|#|[()\[\]]')
QUOTES = re.compile('"""')  # all that counts within a docstring
WORD = re.compile(r"[A-Za-z_][A-Za-z0-9_]*")
# Inside an open docstring, only what can be nothing else than a declaration counts as one.
HEADER = re.compile(rf"(?:{'|'.join(KEYWORDS)})[ \t]+[A-Za-z_][A-Za-z0-9_]*[ \t]*[(:]")
DECLARES = re.compile(rf"^({'|'.join(KEYWORDS)})[ \t]+([A-Za-z_][A-Za-z0-9_]*)", re.MULTILINE)
# What belongs into a declaration: a line like this begins none, wherever it stands.
INNER = re.compile(
    r"(?:requires|achieves|calls|for|when|scene|goal|run|success)\b|[A-Za-z_][A-Za-z0-9_]*[ \t]*\("
)
BLOCKS = ("api", "program", "task")  # what has lines of its own below the first
PARTNERS = {"(": ")", "[": "]"}


@dataclass(frozen=True)
class Shift:
    """What stood in columns `column` to `end` of a line was replaced by so many characters."""

    column: int
    end: int
    width: int

    def original(self, column: int) -> int:
        """Where in the user's line a column of the mended line comes from."""
        if column >= self.column + self.width:
            return column - self.width + self.end - self.column
        return min(column, self.end)


@dataclass(frozen=True)
class Piece:
    """The text of one declaration, and the line at which it begins.

    The text may be mended, to read on where the user's does not parse; `shifts` are then by line,
    and every place is one of the user's text.
    """

    text: str
    line: int
    path: Path | None
    shifts: Mapping[int, Shift] = field(default_factory=dict)
    mistakes: tuple[Diagnostic, ...] = ()  # found in cutting

    @property
    def keyword(self) -> str:
        """The first word, or nothing if the piece begins with something else."""
        word = WORD.match(self.text)
        return word.group() if word else ""

    def span(self, line: int, column: int, width: int = 1) -> Span:
        """A stretch of one line, as far as the line goes; `line` counts from one within the piece."""
        rows = self.text.split("\n")
        line = min(line, len(rows))
        last = len(rows[line - 1]) + 1
        return self.stretch(line, min(column, last), line, min(column + width, last))

    def stretch(self, line: int, column: int, end_line: int, end_column: int) -> Span:
        """The place in the whole text; lines count from one within the piece."""
        if self.shifts:
            column, end_column = self._original(line, column), self._original(end_line, end_column)
        above = self.line - 1
        return Span(self.path, line + above, column, end_line + above, end_column)

    def _original(self, line: int, column: int) -> int:
        shift = self.shifts.get(line)
        return column if shift is None else shift.original(column)

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
    return _joined(
        Piece("\n".join(lines[start:end]).rstrip() + "\n", start + 1, path)
        for start, end in zip(starts, ends, strict=True)
    )


def _joined(pieces: Iterable[Piece]) -> list[Piece]:
    """Lines at the margin that can only belong to the declaration above are taken to do so."""
    joined: list[Piece] = []
    for piece in pieces:
        if joined and joined[-1].keyword in BLOCKS and INNER.match(piece.text):
            joined[-1] = _join(joined[-1], piece)
        else:
            joined.append(piece)
    return joined


def _join(above: Piece, below: Piece) -> Piece:
    rows = above.text.rstrip("\n").split("\n")
    rows += [""] * (below.line - above.line - len(rows))
    indents = [len(row) - len(row.lstrip()) for row in rows[1:] if row.strip()]
    width = min(indents, default=0) or 4
    added = below.text.rstrip("\n").split("\n")
    numbers = [len(rows) + index for index, row in enumerate(added, start=1) if row.strip()]
    edits = [Edit(above.stretch(number, 1, number, 1), " " * width) for number in numbers]
    if above.mistakes:
        first = above.mistakes[0]
        assert first.fix is not None
        mistake = replace(first, fix=replace(first.fix, also=(*first.fix.also, *edits)))
    else:
        name = DECLARES.match(above.text)
        what = f"'{above.keyword} {name.group(2)}'" if name else f"the {above.keyword}"
        message = f"this line stands at the margin; what belongs to {what} is indented below it"
        fix = Fix(edits[0].span, edits[0].replacement, tuple(edits[1:]))
        mistake = Diagnostic("E002", message, below.at(0, len(below.keyword)), fix=fix)
    text = "\n".join([*rows, *(" " * width + row if row.strip() else row for row in added)]) + "\n"
    shifts = {**above.shifts, **{number: Shift(1, 1, width) for number in numbers}}
    return replace(above, text=text, shifts=shifts, mistakes=(mistake,))


def _begins(line: str, depth: int, quoted: bool, previous: str) -> bool:
    if quoted:
        return HEADER.match(line) is not None
    if not line[:1].strip() or line.startswith("#"):
        return False
    if line.startswith('"""'):
        word = WORD.match(previous)
        return word is None or nearest(word.group(), KEYWORDS) != "library"
    word = WORD.match(line)
    return depth == 0 or (word is not None and word.group() in KEYWORDS)


def _marks(line: str, depth: int, quoted: bool) -> tuple[int, bool]:
    """How many brackets, and whether a docstring, are open at the end of the line."""
    if not quoted and '"' not in line and "#" not in line and "[" not in line:
        opened, closed = line.count("("), line.count(")")
        if opened == closed and "]" not in line:
            return depth, quoted  # as nearly every line, told at once
    position = 0
    while match := (QUOTES if quoted else MARKS).search(line, position):
        mark, position = match.group(), match.end()
        if mark == '"""':
            quoted = not quoted
        elif mark == "#":
            break
        elif mark[0] != '"':
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
        elif mark[0] != '"':
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
    meant = ELSEWHERE.get(found) or nearest(found, KEYWORDS) if found else None
    if meant:
        message = f"nothing begins with '{found}'; did you mean '{meant}'?"
        return Diagnostic("E002", message, span, help=help, fix=Fix(span, meant))
    message = f"no declaration begins with {found or piece.text[0]!r}"
    if piece.text[0].isspace():
        message = "this line is indented, and there is no declaration above it"
    return Diagnostic("E002", message, span, help=help)


def declared(piece: Piece) -> Iterator[tuple[str, str]]:
    """The names, each with its namespace, that a piece declares as far as its words tell."""
    for keyword, name in DECLARES.findall(piece.text):
        yield SPACES[keyword], name
    words = set(WORD.findall(piece.text))
    if piece.keyword == "enum":
        yield from (("value", word) for word in words)
    elif piece.keyword not in KEYWORDS:
        yield from ((space, word) for space in set(SPACES.values()) for word in words)


def continued(rows: Sequence[str]) -> int:
    """How many rows the first one runs on over, in brackets or a docstring; none if it never ends."""
    depth, quoted = 0, False
    for index, row in enumerate(rows):
        depth, quoted = _marks(row, depth, quoted)
        if not depth and not quoted:
            return index
    return 0
