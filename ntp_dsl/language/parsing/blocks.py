"""From text to blocks, split where a line begins at the margin, so that one mistake does not hide another."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

from ntp_dsl.language.diagnostics.diagnostics import Diagnostic, Edit, Fix
from ntp_dsl.language.diagnostics.spelling import is_misspelt, nearest
from ntp_dsl.language.syntax.nodes import Span

# The namespace in which each keyword declares a name; the first two declare none.
NAMESPACES = {
    "library": "", "use": "", "type": "type", "enum": "type", "record": "type", "constant": "value",
    "predicate": "predicate", "api": "call", "program": "call", "task": "task",
}  # fmt: skip
KEYWORDS = tuple(NAMESPACES)
# Words of other languages, and the keywords for them.
FOREIGN_KEYWORDS = {
    "import": "use", "include": "use", "from": "use", "using": "use", "require": "use", "open": "use",
    "module": "library", "package": "library", "domain": "library", "namespace": "library",
    "class": "type", "object": "type", "struct": "record", "tuple": "record", "dataclass": "record",
    "enumeration": "enum", "const": "constant", "fluent": "predicate", "relation": "predicate",
    "property": "predicate", "skill": "api", "action": "api", "primitive": "api", "extern": "api",
    "def": "program", "fn": "program", "fun": "program", "func": "program", "function": "program",
    "proc": "program", "procedure": "program", "method": "program", "routine": "program",
    "problem": "task", "goal": "task", "experiment": "task", "test": "task",
}  # fmt: skip
# Those of which each means one thing.
CERTAIN_KEYWORDS = frozenset(
    "import include using class struct dataclass enumeration const def fn fun func function proc procedure"
    " routine".split()
)
CALLS = re.compile(r"\n[ \t]+(?:(?:for|when|if|foreach)\b|\w+\()")  # the body of a program, not of an api
MARKS = re.compile(r'"""|"[^"\n]*"|#|[()\[\]]')
QUOTES = re.compile('"""')  # the only mark within a docstring
WORD = re.compile(r"[A-Za-z_][A-Za-z0-9_]*")
# Inside an open docstring, only what cannot be prose counts as a declaration.
HEADER = re.compile(rf"(?:{'|'.join(KEYWORDS)})[ \t]+[A-Za-z_][A-Za-z0-9_]*[ \t]*[(:]")
DECLARES = re.compile(rf"^({'|'.join(KEYWORDS)})[ \t]+([A-Za-z_][A-Za-z0-9_]*)", re.MULTILINE)
# A line that belongs into a declaration, also where it is at the margin.
INNER = re.compile(
    r"(?:requires|achieves|says|calls|for|when|else|scene|initially|goal|run|success)\b"
    r"|[A-Za-z_][A-Za-z0-9_]*[ \t]*\("
)
WITH_BODY = ("api", "program", "task")  # declarations with lines below the first
PARTNERS = {"(": ")", "[": "]"}


@dataclass(frozen=True)
class ColumnMap:
    """Columns `column` to `end` of a line were replaced by `width` characters."""

    column: int
    end: int
    width: int

    def original(self, column: int) -> int:
        """Return the column of the user's line for one of the repaired line."""
        if column >= self.column + self.width:
            return column - self.width + self.end - self.column
        return min(column, self.end)


@dataclass(frozen=True)
class Block:
    """The text of one declaration, and the line at which it begins.

    The text may be repaired, to read on where the user's does not parse; `column_maps` are then by line,
    and every span is one of the user's text.
    """

    text: str
    line: int
    path: Path | None
    column_maps: Mapping[int, ColumnMap] = field(default_factory=dict)
    diagnostics: tuple[Diagnostic, ...] = ()  # found in splitting

    @property
    def keyword(self) -> str:
        """The first word, or "" if the block begins with something else."""
        word = WORD.match(self.text)
        return word.group() if word else ""

    def span(self, line: int, column: int, width: int = 1) -> Span:
        """Return a span in one line, as far as the line goes; `line` counts from one within the block."""
        rows = self.text.split("\n")
        line = min(line, len(rows))
        last = len(rows[line - 1]) + 1
        return self.stretch(line, min(column, last), line, min(column + width, last))

    def stretch(self, line: int, column: int, end_line: int, end_column: int) -> Span:
        """Return a span in the whole text; lines count from one within the block."""
        if self.column_maps:
            column, end_column = self._original(line, column), self._original(end_line, end_column)
        above = self.line - 1
        return Span(self.path, line + above, column, end_line + above, end_column)

    def _original(self, line: int, column: int) -> int:
        column_map = self.column_maps.get(line)
        return column if column_map is None else column_map.original(column)

    def at(self, offset: int, width: int = 1) -> Span:
        """Return the span of characters of the block's text."""
        before = self.text[:offset]
        return self.span(before.count("\n") + 1, offset - (before.rfind("\n") + 1) + 1, width)


def split_blocks(text: str, path: Path | None) -> list[Block]:
    """Split where a line begins at the margin, unless a bracket or a docstring is open there."""
    starts: list[int] = []
    lines = text.split("\n")
    depth, quoted = 0, False
    for index, line in enumerate(lines):
        stray = not starts and line.strip() and not line.lstrip().startswith("#")
        if stray or _begins_block(line, depth, quoted, lines[starts[-1]] if starts else ""):
            starts.append(index)
            depth, quoted = 0, False
        depth, quoted = _open_after(line, depth, quoted)
    ends = [*starts, len(lines)][1:]
    return _joined(
        Block("\n".join(lines[start:end]).rstrip() + "\n", start + 1, path)
        for start, end in zip(starts, ends, strict=True)
    )


def _joined(blocks: Iterable[Block]) -> list[Block]:
    """Join lines at the margin that can only belong to the declaration above with it."""
    joined: list[Block] = []
    for block in blocks:
        if joined and joined[-1].keyword in WITH_BODY and INNER.match(block.text):
            joined[-1] = _join(joined[-1], block)
        else:
            joined.append(block)
    return joined


def _join(above: Block, below: Block) -> Block:
    rows = above.text.rstrip("\n").split("\n")
    rows += [""] * (below.line - above.line - len(rows))
    indents = [len(row) - len(row.lstrip()) for row in rows[1:] if row.strip()]
    width = min(indents, default=0) or 4
    added = below.text.rstrip("\n").split("\n")
    opens = added[0].split("#")[0].rstrip().endswith(":")  # then what is below it moves with it
    moved = [index for index, row in enumerate(added) if row.strip() and (opens or not row[0].isspace())]
    numbers = [len(rows) + index + 1 for index in moved]
    edits = [Edit(above.stretch(number, 1, number, 1), " " * width) for number in numbers]
    if above.diagnostics:
        first = above.diagnostics[0]
        assert first.fix is not None
        diagnostic = replace(first, fix=replace(first.fix, also=(*first.fix.also, *edits)))
    else:
        name = DECLARES.match(above.text)
        what = f"'{above.keyword} {name.group(2)}'" if name else f"the {above.keyword}"
        message = f"this line is at the margin; what belongs to {what} is indented below it"
        is_flat = len({*indents}) <= 1 and not above.text.rstrip().endswith(":")
        fix = Fix(edits[0].span, edits[0].replacement, tuple(edits[1:]), certain=is_flat)
        diagnostic = Diagnostic("E002", message, below.at(0, len(below.keyword)), fix=fix)
    shifted = [" " * width + row if index in moved else row for index, row in enumerate(added)]
    text = "\n".join([*rows, *shifted]) + "\n"
    column_maps = {**above.column_maps, **{number: ColumnMap(1, 1, width) for number in numbers}}
    return replace(above, text=text, column_maps=column_maps, diagnostics=(diagnostic,))


def _begins_block(line: str, depth: int, quoted: bool, previous: str) -> bool:
    if quoted:
        return HEADER.match(line) is not None
    if not line[:1].strip() or line.startswith("#"):
        return False
    if line.startswith('"""'):
        word = WORD.match(previous)
        return word is None or nearest(word.group(), KEYWORDS) != "library"
    word = WORD.match(line)
    return depth == 0 or (word is not None and word.group() in KEYWORDS)


def _open_after(line: str, depth: int, quoted: bool) -> tuple[int, bool]:
    """Return how many brackets, and whether a docstring, are open at the end of the line."""
    if not quoted and '"' not in line and "#" not in line and "[" not in line:
        opened, closed = line.count("("), line.count(")")
        if opened == closed and "]" not in line:
            return depth, quoted  # a quick answer for nearly every line
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
    """Yield brackets and open docstrings with their offsets; skip comments and docstrings."""
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


def unbalanced(block: Block) -> Iterator[Diagnostic]:
    """Report the first bracket or docstring that has no partner."""
    stack: list[tuple[str, int]] = []
    for mark, offset in _open_marks(block.text):
        if mark == '"""':
            yield Diagnostic("E004", 'this docstring is never closed by """', block.at(offset, 3))
            return
        if mark in PARTNERS:
            stack.append((mark, offset))
        elif not stack or PARTNERS[stack[-1][0]] != mark:
            message = f"this '{mark}' closes nothing that was opened"
            yield Diagnostic("E003", message, block.at(offset))
            return
        else:
            stack.pop()
    for mark, offset in stack[:1]:
        message = f"this '{mark}' is never closed by a '{PARTNERS[mark]}'"
        yield Diagnostic("E003", message, block.at(offset))


def misspelt_keyword(block: Block) -> Diagnostic:
    """Report a block that begins with none of the keywords."""
    found = block.keyword
    span = block.at(0, max(1, len(found)))
    help = f"a line at the margin begins with one of: {', '.join(KEYWORDS)}"
    if (imported := re.match(r"from[ \t]+(\w+)[ \t]+import[ \t]*\*", block.text)) is not None:
        whole = block.at(0, imported.end())
        fix = Fix(whole, f"use {imported.group(1)}", certain=True)
        return Diagnostic("E002", "a library is used with 'use'", span, help=help, fix=fix)
    meant = FOREIGN_KEYWORDS.get(found) or nearest(found, KEYWORDS) if found else None
    if meant:
        is_clear = found in CERTAIN_KEYWORDS and (meant != "program" or CALLS.search(block.text) is not None)
        certain = is_clear or is_misspelt(found, meant, KEYWORDS)
        message = f"no declaration begins with '{found}'; did you mean '{meant}'?"
        return Diagnostic("E002", message, span, help=help, fix=Fix(span, meant, certain=certain))
    message = f"no declaration begins with {found or block.text[0]!r}"
    if block.text[0].isspace():
        message = "this line is indented, and there is no declaration above it"
    return Diagnostic("E002", message, span, help=help)


def declared_names(block: Block) -> Iterator[tuple[str, str]]:
    """Yield the names, each with its namespace, that a block declares as far as its words tell."""
    for keyword, name in DECLARES.findall(block.text):
        yield NAMESPACES[keyword], name
    words = set(WORD.findall(block.text))
    if block.keyword == "enum":
        yield from (("value", word) for word in words)
    elif block.keyword not in KEYWORDS:
        yield from ((space, word) for space in set(NAMESPACES.values()) for word in words)


def continuation(rows: Sequence[str]) -> int:
    """Return over how many rows the first one continues, in brackets or a docstring; 0 if it never ends."""
    depth, quoted = 0, False
    for index, row in enumerate(rows):
        depth, quoted = _open_after(row, depth, quoted)
        if not depth and not quoted:
            return index
    return 0
