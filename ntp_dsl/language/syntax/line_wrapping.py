"""From one logical line to the physical lines that it takes: wrapped in brackets, with its comments."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace

WIDTH = 100
STEP = 4  # columns of indentation
WORD = re.compile(r'"[^"\n]*"|[A-Za-z_]\w*|[0-9]+(?:\.[0-9]+)?(?:[eE][+-]?[0-9]+)?', re.ASCII)
MARK = re.compile(r'"[^"\n]*"|\w+|[()\[\],]')
# What precedes an expression that runs to the end of the line, or to the colon there.
BEFORE_EXPRESSION = re.compile(r"requires |achieves |success: +|when |for \w+ in \w+ if |")
BEFORE_DETAILS = re.compile(r"(?:scene: +)?\w+: +[0-9.]+ [\w\[\]]+ on \w+ with |says (?=\")")


@dataclass(frozen=True)
class Comment:
    """A comment within a logical line: above the physical line of its word, or at the end of that line.

    `word` counts from zero; -1 is the closing bracket.
    """

    text: str
    word: int
    is_above: bool


@dataclass
class Row:
    """A logical line: its indentation in columns, its text on one line, and its comments.

    `above` are whole lines, some of them empty. A docstring's text has its line breaks.
    """

    indent: int
    text: str
    above: list[str] = field(default_factory=list)
    within: list[Comment] = field(default_factory=list)
    behind: list[str] = field(default_factory=list)


def settled(row: Row) -> Row:
    """Return the row with the comments within that none of its lines can take moved above or behind it."""
    if not row.within:
        return row
    lines = [*_wrapped(row.text, row.indent, force=True)]
    begins = _line_of(Comment("", 0, is_above=True), lines)  # an opening bracket may come first
    above = [each for each in row.within if each.is_above and _line_of(each, lines) <= begins]
    behind = [each for each in row.within if not each.is_above and _line_of(each, lines) == len(lines) - 1]
    if not above and not behind:
        return row
    return settled(
        replace(
            row,
            above=row.above + [each.text for each in above],
            within=[each for each in row.within if each not in [*above, *behind]],
            behind=[each.text for each in behind] + row.behind,
        )
    )


def physical_lines(row: Row) -> list[str]:
    """Return the lines of a settled row as they are written, without line ends."""
    margin = " " * row.indent
    lines = [*_wrapped(row.text, row.indent, force=bool(row.within))]
    above: list[list[str]] = [[] for _ in lines]
    beside = [[line] for line in lines]
    for comment in row.within:
        number = _line_of(comment, lines)
        if comment.is_above:
            inner = _indent(lines[number]) + STEP * (number == len(lines) - 1)
            above[number].append(" " * inner + comment.text)
        else:
            beside[number].append(comment.text)
    beside[-1] += row.behind
    written = [line for number in range(len(lines)) for line in (*above[number], "  ".join(beside[number]))]
    return [*(f"{margin}{line}" if line else "" for line in row.above), *written]


def _line_of(comment: Comment, lines: Sequence[str]) -> int:
    if comment.word < 0:
        return len(lines) - 1
    count = 0
    for number, line in enumerate(lines):
        count += sum(1 for _ in WORD.finditer(line))
        if count > comment.word:
            return number
    return len(lines) - 1


def _indent(line: str) -> int:
    return len(line) - len(line.lstrip(" "))


# Wrapping ---------------------------------------------------------------------------------------


def _wrapped(text: str, indent: int, force: bool) -> Iterator[str]:
    """Yield the lines of a row; what is too long is broken in brackets, which are added to an expression."""
    if text.startswith('"""'):
        yield "\n".join(" " * indent + line if line else "" for line in text.split("\n"))
        return
    if not force and indent + len(text) <= WIDTH:
        yield " " * indent + text
        return
    if group := BEFORE_DETAILS.match(text):
        yield " " * indent + group.group() + "("
        for detail in _elements(text[group.end() :]):
            yield from _broken(f"{detail},", indent + STEP)
        yield " " * indent + ")"
        return
    head = BEFORE_EXPRESSION.match(text)
    assert head is not None
    end = len(text) - text.endswith(":")
    expression = text[head.end() : end]
    breaks = _operators(expression)
    if not breaks:
        yield from _broken(text, indent, force)
        return
    yield " " * indent + head.group() + "("
    for part in _parts(expression, breaks):
        yield from _broken(part, indent + STEP)
    yield " " * indent + ")" + text[end:]


def _broken(text: str, indent: int, force: bool = False) -> Iterator[str]:
    """Yield the lines of what is in brackets, one for each operand or element; some parts stay too long."""
    if not force and indent + len(text) <= WIDTH:
        yield " " * indent + text
        return
    if breaks := _operators(text):
        first, *rest = _parts(text, breaks)
        yield from _broken(first, indent)
        deeper = indent + STEP * text.startswith(("for ", "all ", "some "))
        for part in rest:
            yield from _broken(part, deeper)
        return
    opening, closing = _widest_brackets(text)
    if closing == 0:
        yield " " * indent + text
        return
    yield " " * indent + text[: opening + 1]
    elements = _elements(text[opening + 1 : closing])
    for element in elements:
        # A list may end with a comma; an expression in brackets is one element, without one.
        yield from _broken(element + ("," if len(elements) > 1 else ""), indent + STEP)
    yield " " * indent + text[closing:]


def _operators(text: str) -> list[int]:
    """Return where new lines may begin: before the loosest `or`, `and`, or a quantifier's `for`."""
    found: dict[str, list[int]] = {"or": [], "and": [], "for": []}
    body: dict[str, list[int]] = {"or": [], "and": []}  # of a quantifier, where its `for` is cut off
    quantified = False
    for mark, start in _outermost(text):
        if mark in ("all", "some"):
            quantified = True
        elif mark in found and start and quantified == (mark == "for"):
            found[mark].append(start)
        elif mark in body and quantified:
            body[mark].append(start)
    return found["or"] or found["and"] or found["for"] or body["or"] or body["and"]


def _parts(text: str, breaks: Sequence[int]) -> Iterator[str]:
    for start, end in zip([0, *breaks], [*breaks, len(text)], strict=True):
        yield text[start:end].strip()


def _outermost(text: str) -> Iterator[tuple[str, int]]:
    """Yield words and commas outside all brackets, with their places, and the outermost brackets."""
    depth = 0
    for match in MARK.finditer(text):
        mark = match.group()
        depth -= mark in ")]"
        if depth == 0:
            yield mark, match.start()
        depth += mark in "(["


def _widest_brackets(text: str) -> tuple[int, int]:
    """Return where the widest of the outermost brackets opens and closes; (0, 0) where there are none."""
    widest = opening = 0, 0
    for mark, start in _outermost(text):
        if mark in "([":
            opening = start, start
        elif mark in ")]" and start - opening[0] > max(1, widest[1] - widest[0]):
            widest = opening[0], start
    return widest


def _elements(text: str) -> list[str]:
    commas = [start for mark, start in _outermost(text) if mark == ","]
    starts, ends = [0, *(each + 1 for each in commas)], [*commas, len(text)]
    return [text[start:end].strip() for start, end in zip(starts, ends, strict=True)]
