"""From a text or a tree to the canonical layout of a library; the text keeps its comments."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise
from pathlib import Path

from ntp_dsl.language.formatting import comments
from ntp_dsl.language.parsing.blocks import split_blocks
from ntp_dsl.language.parsing.parser import parse
from ntp_dsl.language.syntax import nodes
from ntp_dsl.language.syntax.formatter import declaration_rows, header_rows, use_row
from ntp_dsl.language.syntax.line_wrapping import STEP, WIDTH, Row, physical_lines, settled

LEADING = ("library", "use")  # come first, in this order
LIGHT = ("type", "enum", "record", "constant", "predicate")  # may follow one another without an empty line


@dataclass
class _Entry:
    """A declaration, `library` or `use`: its first word, its rows, and comments below them."""

    keyword: str
    rows: list[Row]
    below: list[str] = field(default_factory=list)

    @property
    def is_light(self) -> bool:
        rows = [row for row in self.rows if not row.text.startswith('"""')]
        return self.keyword in LIGHT and len(rows) == 1


def format_library(library: nodes.Library) -> str:
    """Return a library in canonical layout, from its tree alone."""
    entries = _entries(library)
    for before, entry in pairwise(entries):
        if before.keyword != entry.keyword:
            entry.rows[0].above = [""]
    return _write(entries, [])


def format_text(text: str, path: Path | None = None) -> str:
    """Return the same library in canonical layout, with its comments. Raises `SourceError`."""
    library = parse(text, path)
    text = text.replace("\r\n", "\n").replace("\r", "\n")
    found = split_blocks(text, path)
    lines = text.split("\n")
    starts = [block.line - 1 for block in found]
    above = comments.lines_of(comments.scan("\n".join(lines[: starts[0]])))
    order = sorted(range(len(found)), key=lambda index: _rank(found[index].keyword))
    entries = _entries(library)
    entry_of = dict(zip(order, entries, strict=True))
    for index, (start, end) in enumerate(zip(starts, [*starts[1:], len(lines)], strict=True)):
        entry = entry_of[index]
        tokens = comments.scan("\n".join(lines[start:end]))
        if start and not lines[start - 1].strip():
            above.append("")
        entry.rows[0].above = above
        entry.below, above = comments.attach(tokens, entry.rows, entry.keyword)
    return _write(entries, above)


def _rank(keyword: str) -> int:
    return LEADING.index(keyword) if keyword in LEADING else len(LEADING)


def _entries(library: nodes.Library) -> list[_Entry]:
    entries = [_Entry("library", header_rows(library))]
    entries += [_Entry("use", [use_row(use)]) for use in library.uses]
    for declaration in library.declarations:
        rows = declaration_rows(declaration)
        entries.append(_Entry(rows[0].text.split()[0], rows))
    return entries


def _write(entries: Sequence[_Entry], footer: list[str]) -> str:
    for entry in entries:
        entry.rows = _joined([settled(row) for row in entry.rows])
    lines = [*_write_lines(entries[0])]
    for before, entry in pairwise(entries):
        if not (before.is_light and entry.is_light or before.keyword == entry.keyword == "use"):
            lines.append("")
        lines += _write_lines(entry)
    return "\n".join(_single_spaced([*lines, *footer])).rstrip("\n") + "\n"


def _joined(rows: list[Row]) -> list[Row]:
    """Join a composed predicate that fits on one line."""
    if len(rows) != 2 or not rows[0].text.startswith("predicate ") or rows[1].text[0] == '"':
        return rows
    head, body = rows
    text = f"{head.text} {body.text}"
    if len(text) > WIDTH or any([head.within, head.behind, body.within, *body.above]):
        return rows
    return [replace(head, text=text, behind=body.behind)]


def _write_lines(entry: _Entry) -> Iterator[str]:
    for number, row in enumerate(entry.rows):
        if number == 1:  # only comments come between a header and its body
            while row.above and not row.above[0]:
                row.above.pop(0)
        yield from physical_lines(row)
    yield from (" " * STEP + line if line else "" for line in entry.below)


def _single_spaced(lines: Sequence[str]) -> Iterator[str]:
    """Drop empty lines at the beginning, and all but one of several."""
    before = ""
    for line in lines:
        if line or before:
            yield line
        before = line
