"""From a piece that does not parse to what can be read of it: one mistake is mended, the next one found."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

from ntp_dsl.language.diagnostics.diagnostics import Diagnostic, Fix
from ntp_dsl.language.parsing.blocks import BLOCKS, DECLARES, Piece, Shift, continued, declared
from ntp_dsl.language.parsing.syntax_repairs import is_word, meant
from ntp_dsl.language.parsing.tree_builder import Item

Attempt = Callable[[Piece], tuple[Item | None, Sequence[Diagnostic]]]

MOST_ROUNDS = 20
MOST_TRIES = 20
MOST_LETTERS = 40_000  # read again and again, so that a long text is answered at once
STUB = '"""."""'  # stands for a block of which nothing is left


@dataclass(frozen=True)
class Parsed:
    """What could be read of a piece. Where `is_whole` is false, some of its lines are missing."""

    piece: Piece  # mended
    item: Item | None
    mistakes: tuple[Diagnostic, ...] = ()
    is_whole: bool = True
    lost: frozenset[tuple[str, str]] = frozenset()  # what its words seem to declare, and nobody can read
    guessed: frozenset[int] = frozenset()  # lines that are read as they were probably meant


def recover(piece: Piece, attempt: Attempt) -> Parsed:
    """Read a piece, and tell all its mistakes that do not follow from one another."""
    item, found = attempt(piece)
    page = _Page(piece, attempt)
    mistakes = dict.fromkeys(piece.mistakes)
    rounds = min(MOST_ROUNDS, MOST_LETTERS // len(piece.text))
    while found:
        told = [meant(each, page.piece(), attempt) for each in found]
        mistakes |= dict.fromkeys(each for each in told if not page.is_made_up(each))
        rounds -= 1
        known = [better if page.is_sure(better) else each for each, better in zip(found, told, strict=True)]
        if rounds < 0 or not page.mend(known):
            page.is_lost = True
            break
        item, found = attempt(page.piece())
    mended = page.piece()
    lost = frozenset[tuple[str, str]]()
    page.is_whole = page.is_whole and not page.guessed  # what a guess says proves nothing
    if not page.is_whole or page.is_lost:
        lost = frozenset([*declared(piece), *declared(mended)])
    item = None if page.is_lost else item
    is_whole = page.is_whole and not page.is_lost
    return Parsed(mended, item, tuple(mistakes), is_whole, lost, frozenset(page.guessed))


class _Page:
    """The lines of a piece, from which what cannot be read is taken out."""

    def __init__(self, piece: Piece, attempt: Attempt) -> None:
        self._original = piece
        self._attempt = attempt
        self._rows = piece.text.rstrip("\n").split("\n")
        self._shifts = dict(piece.shifts)  # by the row's number, from one
        self._is_beheaded = False
        self.is_whole = True
        self.is_lost = False  # nobody can tell how the thing is declared
        self.guessed: set[int] = set()  # lines, of the user's text
        self._tries = min(MOST_TRIES, MOST_LETTERS // len(piece.text))  # of fixes

    def piece(self) -> Piece:
        return replace(self._original, text="\n".join(self._rows) + "\n", shifts=dict(self._shifts))

    def is_made_up(self, mistake: Diagnostic) -> bool:
        """Whether it is about what stands for a block, not about the user's text."""
        row = mistake.span.line - self._original.line
        return row < len(self._rows) and self._rows[row].strip() == STUB

    def is_sure(self, mistake: Diagnostic) -> bool:
        """Whether to read on from its fix: another word in place of one, or what leaves nothing to wish for.

        Of a line that was guessed as a whole no more is said: what is wrong there may be the guess.
        """
        if is_word(mistake):
            return True
        fix = mistake.fix
        if fix is None or fix.also or fix.span.line != fix.span.end_line or "\n" in fix.replacement:
            return False
        row = fix.span.line - self._original.line
        if not 0 <= row < len(self._rows) or row + 1 in self._shifts or not self._tries:
            return False
        self._tries -= 1
        rows = list(self._rows)
        is_end = not rows[row][fix.span.end_column - 1 :].split("#")[0].strip()
        rows[row] = _edited(rows[row], fix)
        if self._attempt(replace(self.piece(), text="\n".join(rows) + "\n"))[1]:
            return False
        if not (is_end and fix.replacement == ":"):  # which changes nothing of what the line says
            self.guessed.add(fix.span.line)
        return True

    def mend(self, mistakes: Sequence[Diagnostic]) -> bool:
        """Take the mistakes out of the text; false where that leaves nothing to read."""
        return all([self._mend(each) for each in mistakes])

    def _mend(self, mistake: Diagnostic) -> bool:
        row = min(mistake.span.line - self._original.line, len(self._rows) - 1)
        if mistake.fix is not None and self._apply(mistake.fix):
            return True
        self.is_whole = False
        if mistake.code == "E004":  # an open docstring: nothing after it can be told from it
            self._rows[row + 1 :] = [""] * (len(self._rows) - row - 1)
        column = mistake.span.column
        return self._align(row, column) or self._remove(self._start(row))

    def _apply(self, fix: Fix) -> bool:
        span = fix.span
        row = span.line - self._original.line
        if row + 1 in self._shifts or fix.also or span.line != span.end_line:
            return False
        self._rows[row] = _edited(self._rows[row], fix)
        self._shifts[row + 1] = Shift(span.column, span.end_column, len(fix.replacement))
        return True

    def _align(self, row: int, column: int) -> bool:
        """A line that is indented like no other is taken to continue the line above it."""
        indent = self._indent(row)
        above = next((each for each in range(row - 1, 0, -1) if self._has_text(each)), 0)
        target = self._indent(above)
        if above == 0 or column != indent + 1 or self._opens(above) or row + 1 in self._shifts:
            return False
        levels = {self._indent(each) for each in range(row) if self._has_text(each)}
        if indent == target or (indent < target and indent in levels):
            return False
        for each in range(row, len(self._rows)):
            if self._has_text(each) and self._indent(each) < indent:
                break
            if self._has_text(each) and each + 1 not in self._shifts:
                width = self._indent(each) + target - indent
                end = self._indent(each) + 1
                self._rows[each] = " " * width + self._rows[each].lstrip()
                self._shifts[each + 1] = Shift(1, end, width)
        return True

    def _remove(self, start: int) -> bool:
        """Take out a line and what belongs to it; then what would be left without any line."""
        if start == 0:
            return self._behead()
        if not self._rows[start].strip():
            return False
        indent = self._indent(start)
        stop = start + 1 + continued(self._rows[start:])
        while stop < len(self._rows) and (not self._has_text(stop) or self._indent(stop) > indent):
            stop += 1
        self._rows[start:stop] = [""] * (stop - start)
        parent = start - 1
        while not (self._has_text(parent) and self._indent(parent) < indent) and parent:
            parent -= 1
        if not self._has_text(parent) or self._has_children(parent):
            return True
        if parent and self._start(parent):
            return self._remove(self._start(parent))
        self._rows[start] = " " * indent + STUB
        return self.piece().keyword in BLOCKS or self._behead()

    def _behead(self) -> bool:
        """Keep of the first line what can be read alone: the name and the parameters."""
        self.is_whole = False
        if self._is_beheaded:
            return False
        self._is_beheaded = True
        text = "\n".join(self._rows)
        match = DECLARES.match(text)
        keyword = match.group(1) if match else self.piece().keyword
        last = continued(self._rows)
        head = _signature(text) if match else None
        if keyword == "task" and match:
            head = match.group()
        elif head is not None and not self._stands(head, keyword):
            head = None
        if head is None and keyword not in BLOCKS:
            return False
        self.is_lost = head is None
        colon = "" if keyword in {"predicate", "record"} else ":"
        name = match.group() if match else f"{keyword} _"
        rows = (head or name + "()" * (keyword != "task")).split("\n")
        rows[-1] += colon
        below = self._rows[last + 1 :] if keyword in BLOCKS else []
        filled = [*rows, *[""] * (last + 1 - len(rows)), *below]
        self._rows = filled
        if keyword in BLOCKS and not any(map(self._has_text, range(len(rows), len(filled)))):
            self._rows[len(rows) :] = [f"    {STUB}"]
        return True

    def _stands(self, head: str, keyword: str) -> bool:
        if keyword == "predicate" and "->" in self._original.text.split(":")[-1]:
            return False  # a reading whose result cannot be read
        ending = f":\n    {STUB}\n" if keyword == "program" else "\n"
        return not self._attempt(replace(self.piece(), text=head + ending))[1]

    def _start(self, row: int) -> int:
        """The row in which the line begins that `row` continues."""
        start = 0
        while (end := start + continued(self._rows[start:])) < row:
            start = end + 1
        return start

    def _has_children(self, row: int) -> bool:
        below = (each for each in range(row + 1, len(self._rows)) if self._has_text(each))
        first = next(below, None)
        return first is not None and self._indent(first) > self._indent(row)

    def _has_text(self, row: int) -> bool:
        bare = self._rows[row].strip()
        return bool(bare) and not bare.startswith("#")

    def _indent(self, row: int) -> int:
        return len(self._rows[row]) - len(self._rows[row].lstrip())

    def _opens(self, row: int) -> bool:
        return self._rows[row].split("#")[0].rstrip().endswith(":")


def _edited(text: str, fix: Fix) -> str:
    return text[: fix.span.column - 1] + fix.replacement + text[fix.span.end_column - 1 :]


def _signature(text: str) -> str | None:
    """The text as far as the bracket that closes the parameters."""
    start = text.find("(")
    end = text.find(")", start)
    return text[: end + 1] if 0 <= start < end else None
