"""From a block that does not parse to what can be read of it: repair one mistake, find the next one."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

from ntp_dsl.language.diagnostics.diagnostics import Diagnostic, Fix
from ntp_dsl.language.parsing.blocks import (
    DECLARES,
    WITH_BODY,
    Block,
    ColumnMap,
    continuation,
    declared_names,
)
from ntp_dsl.language.parsing.parsed import Parsed
from ntp_dsl.language.parsing.syntax_repairs import replaces_word, with_fix
from ntp_dsl.language.parsing.tree_builder import Item

Attempted = tuple[Item | None, Sequence[Diagnostic]]
Attempt = Callable[[Block], Attempted]

MAX_ROUNDS = 20
MAX_TRIES = 20
MAX_CHARACTERS = 40_000  # read in all rounds together, so that a long text is answered at once
STUB = '"""."""'  # a placeholder for a body of which nothing is left


def recover(block: Block, attempt: Attempt, first: Attempted) -> Parsed:
    """Read a block, and find all its mistakes that do not follow from one another.

    Args:
        first: what was attempted of the block as it is.
    """
    item, found = first
    text = _BlockText(block, attempt)
    diagnostics = dict.fromkeys(block.diagnostics)
    rounds = min(MAX_ROUNDS, MAX_CHARACTERS // len(block.text))
    while found:
        with_fixes = [text.with_fix(each) for each in found]
        diagnostics |= dict.fromkeys(each for each in with_fixes if not text.is_about_stub(each))
        rounds -= 1
        chosen = [
            better if text.is_sure(better) else each for each, better in zip(found, with_fixes, strict=True)
        ]
        if rounds < 0 or not text.repair(chosen):
            text.is_lost = True
            break
        item, found = attempt(text.block())
    repaired = text.block()
    unreadable = frozenset[tuple[str, str]]()
    text.is_whole = text.is_whole and not text.guessed  # a guess proves nothing
    if not text.is_whole or text.is_lost:
        unreadable = frozenset([*declared_names(block), *declared_names(repaired)])
    item = None if text.is_lost else item
    is_whole = text.is_whole and not text.is_lost
    return Parsed(repaired, item, tuple(diagnostics), is_whole, unreadable, frozenset(text.guessed))


class _BlockText:
    """The lines of a block, from which what cannot be read is removed."""

    def __init__(self, block: Block, attempt: Attempt) -> None:
        self._original = block
        self._attempt = attempt
        self._rows = block.text.rstrip("\n").split("\n")
        self._column_maps = dict(block.column_maps)  # by the row's number, from one
        self._is_signature_only = False
        self.is_whole = True
        self.is_lost = False  # it is unknown what the block declares
        self.guessed: set[int] = set()  # lines, of the user's text
        self._tries = min(MAX_TRIES, MAX_CHARACTERS // len(block.text))  # of fixes

    def block(self) -> Block:
        return replace(self._original, text="\n".join(self._rows) + "\n", column_maps=dict(self._column_maps))

    def with_fix(self, diagnostic: Diagnostic) -> Diagnostic:
        """Return the diagnostic with a fix; only an offer where lines are missing by now."""
        better = with_fix(diagnostic, self.block(), self._attempt)
        if better.fix is None or self.is_whole:
            return better
        return replace(better, fix=replace(better.fix, certain=False))

    def is_about_stub(self, diagnostic: Diagnostic) -> bool:
        """Return whether it is about the placeholder for a body, not about the user's text."""
        row = diagnostic.span.line - self._original.line
        return row < len(self._rows) and self._rows[row].strip() == STUB

    def is_sure(self, diagnostic: Diagnostic) -> bool:
        """Return whether to read on from its fix: another word in place of one, or one that leaves no error.

        No more is reported about a guessed line: what is wrong there may be the guess.
        """
        if replaces_word(diagnostic):
            return True
        fix = diagnostic.fix
        if fix is None or fix.also or fix.span.line != fix.span.end_line or "\n" in fix.replacement:
            return False
        row = fix.span.line - self._original.line
        if not 0 <= row < len(self._rows) or row + 1 in self._column_maps or not self._tries:
            return False
        self._tries -= 1
        rows = list(self._rows)
        is_end = not rows[row][fix.span.end_column - 1 :].split("#")[0].strip()
        rows[row] = _edited(rows[row], fix)
        if self._attempt(replace(self.block(), text="\n".join(rows) + "\n"))[1]:
            return False
        if not (is_end and fix.replacement == ":"):  # which does not change the meaning of the line
            self.guessed.add(fix.span.line)
        return True

    def repair(self, diagnostics: Sequence[Diagnostic]) -> bool:
        """Remove the mistakes from the text; return False where that leaves nothing to read."""
        return all([self._repair(each) for each in diagnostics])

    def _repair(self, diagnostic: Diagnostic) -> bool:
        row = min(diagnostic.span.line - self._original.line, len(self._rows) - 1)
        if diagnostic.fix is not None and self._apply(diagnostic.fix):
            return True
        self.is_whole = False
        if diagnostic.code == "E004":  # an open docstring: what follows cannot be told from it
            self._rows[row + 1 :] = [""] * (len(self._rows) - row - 1)
        column = diagnostic.span.column
        return self._align(row, column) or self._remove(self._start(row))

    def _apply(self, fix: Fix) -> bool:
        span = fix.span
        row = span.line - self._original.line
        if row + 1 in self._column_maps or fix.also or span.line != span.end_line:
            return False
        self._rows[row] = _edited(self._rows[row], fix)
        self._column_maps[row + 1] = ColumnMap(span.column, span.end_column, len(fix.replacement))
        return True

    def _align(self, row: int, column: int) -> bool:
        """Indent a line that is indented like no other as the line above it."""
        indent = self._indent(row)
        above = next((each for each in range(row - 1, 0, -1) if self._has_text(each)), 0)
        target = self._indent(above)
        if above == 0 or column != indent + 1 or self._opens(above) or row + 1 in self._column_maps:
            return False
        levels = {self._indent(each) for each in range(row) if self._has_text(each)}
        if indent == target or (indent < target and indent in levels):
            return False
        for each in range(row, len(self._rows)):
            if self._has_text(each) and self._indent(each) < indent:
                break
            if self._has_text(each) and each + 1 not in self._column_maps:
                width = self._indent(each) + target - indent
                end = self._indent(each) + 1
                self._rows[each] = " " * width + self._rows[each].lstrip()
                self._column_maps[each + 1] = ColumnMap(1, end, width)
        return True

    def _remove(self, start: int) -> bool:
        """Remove a line and its body, then a header that would be left without a body."""
        if start == 0:
            return self._keep_signature()
        if not self._rows[start].strip():
            return False
        indent = self._indent(start)
        stop = start + 1 + continuation(self._rows[start:])
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
        return self.block().keyword in WITH_BODY or self._keep_signature()

    def _keep_signature(self) -> bool:
        """Reduce the first line to what can be read alone: the name and the parameters."""
        self.is_whole = False
        if self._is_signature_only:
            return False
        self._is_signature_only = True
        text = "\n".join(self._rows)
        match = DECLARES.match(text)
        keyword = match.group(1) if match else self.block().keyword
        last = continuation(self._rows)
        head = _signature(text) if match else None
        if keyword == "task" and match:
            head = match.group()
        elif head is not None and not self._can_be_read(head, keyword):
            head = None
        if head is None and keyword not in WITH_BODY:
            return False
        self.is_lost = head is None
        colon = "" if keyword in {"predicate", "record"} else ":"
        name = match.group() if match else f"{keyword} _"
        rows = (head or name + "()" * (keyword != "task")).split("\n")
        rows[-1] += colon
        below = self._rows[last + 1 :] if keyword in WITH_BODY else []
        filled = [*rows, *[""] * (last + 1 - len(rows)), *below]
        self._rows = filled
        if keyword in WITH_BODY and not any(map(self._has_text, range(len(rows), len(filled)))):
            self._rows[len(rows) :] = [f"    {STUB}"]
        return True

    def _can_be_read(self, head: str, keyword: str) -> bool:
        if keyword == "predicate" and "->" in self._original.text.split(":")[-1]:
            return False  # a reading whose result cannot be read
        ending = f":\n    {STUB}\n" if keyword == "program" else "\n"
        return not self._attempt(replace(self.block(), text=head + ending))[1]

    def _start(self, row: int) -> int:
        """Return the row in which the line begins that `row` continues."""
        start = 0
        while (end := start + continuation(self._rows[start:])) < row:
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
    """Return the text as far as the bracket that closes the parameters."""
    start = text.find("(")
    end = text.find(")", start)
    return text[: end + 1] if 0 <= start < end else None
