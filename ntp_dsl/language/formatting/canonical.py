"""From a text or a tree to the one layout of a library; the text keeps its comments."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise
from pathlib import Path

from ntp_dsl.language.formatting import comments
from ntp_dsl.language.parsing.blocks import cut
from ntp_dsl.language.parsing.parser import parse
from ntp_dsl.language.syntax import nodes
from ntp_dsl.language.syntax.formatter import declaration_rows, header_rows, use_row
from ntp_dsl.language.syntax.line_wrapping import STEP, WIDTH, Row, physical, settled

LEADING = ("library", "use")  # come first, in this order
LIGHT = ("type", "enum", "record", "constant", "predicate")  # may follow one another at once


@dataclass
class _Block:
    """A declaration, `library` or `use`: its first word, its rows, and comments below them."""

    keyword: str
    rows: list[Row]
    below: list[str] = field(default_factory=list)

    @property
    def is_light(self) -> bool:
        said = [row for row in self.rows if not row.text.startswith('"""')]
        return self.keyword in LIGHT and len(said) == 1


def format_library(library: nodes.Library) -> str:
    """A library in canonical layout, from its tree alone."""
    blocks = _blocks(library)
    for before, block in pairwise(blocks):
        if before.keyword != block.keyword:
            block.rows[0].above = [""]
    return _written(blocks, [])


def format_text(text: str, path: Path | None = None) -> str:
    """The same library in canonical layout, with its comments. Raises `SourceError`."""
    library = parse(text, path)
    text = text.replace("\r\n", "\n").replace("\r", "\n")
    found = cut(text, path)
    lines = text.split("\n")
    starts = [piece.line - 1 for piece in found]
    above = comments.lines_of(comments.scan("\n".join(lines[: starts[0]])))
    order = sorted(range(len(found)), key=lambda index: _rank(found[index].keyword))
    blocks = _blocks(library)
    block_of = dict(zip(order, blocks, strict=True))
    for index, (start, end) in enumerate(zip(starts, [*starts[1:], len(lines)], strict=True)):
        block = block_of[index]
        tokens = comments.scan("\n".join(lines[start:end]))
        if start and not lines[start - 1].strip():
            above.append("")
        block.rows[0].above = above
        block.below, above = comments.attach(tokens, block.rows, block.keyword)
    return _written(blocks, above)


def _rank(keyword: str) -> int:
    return LEADING.index(keyword) if keyword in LEADING else len(LEADING)


def _blocks(library: nodes.Library) -> list[_Block]:
    blocks = [_Block("library", header_rows(library))]
    blocks += [_Block("use", [use_row(use)]) for use in library.uses]
    for declaration in library.declarations:
        rows = declaration_rows(declaration)
        blocks.append(_Block(rows[0].text.split()[0], rows))
    return blocks


def _written(blocks: Sequence[_Block], footer: list[str]) -> str:
    for block in blocks:
        block.rows = _joined([settled(row) for row in block.rows])
    lines = [*_lines(blocks[0])]
    for before, block in pairwise(blocks):
        if not (before.is_light and block.is_light or before.keyword == block.keyword == "use"):
            lines.append("")
        lines += _lines(block)
    return "\n".join(_single_spaced([*lines, *footer])).rstrip("\n") + "\n"


def _joined(rows: list[Row]) -> list[Row]:
    """A predicate that is composed of little stands on one line."""
    if len(rows) != 2 or not rows[0].text.startswith("predicate ") or rows[1].text[0] == '"':
        return rows
    head, body = rows
    text = f"{head.text} {body.text}"
    if len(text) > WIDTH or any([head.within, head.behind, body.within, *body.above]):
        return rows
    return [replace(head, text=text, behind=body.behind)]


def _lines(block: _Block) -> Iterator[str]:
    for number, row in enumerate(block.rows):
        if number == 1:  # nothing but comments comes between a header and what belongs to it
            while row.above and not row.above[0]:
                row.above.pop(0)
        yield from physical(row)
    yield from (" " * STEP + line if line else "" for line in block.below)


def _single_spaced(lines: Sequence[str]) -> Iterator[str]:
    """Without empty lines at the beginning, and no two in a row."""
    before = ""
    for line in lines:
        if line or before:
            yield line
        before = line
