"""From a text and fixes to the text with every one applied that does not overlap another."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from ntp_dsl.language.diagnostics.diagnostics import Edit, Fix


def apply_fixes(text: str, fixes: Iterable[Fix], path: Path | None = None) -> str:
    """Return the text of the file at `path` with the fixes applied.

    A fix is applied whole or not at all. Of two that touch the same characters the first is applied; the
    next `check` finds what is left.
    """
    applied: list[tuple[int, int, str]] = []
    for fix in dict.fromkeys(fixes):  # several diagnostics may have the same one (the same missing `use`)
        edits = [_offsets(text, edit) for edit in fix.edits]
        is_here = all(edit.span.path == path for edit in fix.edits)
        if is_here and not any(_overlap(edit, other) for edit in edits for other in applied):
            applied += edits
    for start, end, replacement in sorted(applied, key=lambda edit: edit[:2], reverse=True):
        text = text[:start] + replacement + text[end:]
    return text


def _offsets(text: str, edit: Edit) -> tuple[int, int, str]:
    rows = text.split("\n")
    starts = [0]
    for row in rows:
        starts.append(starts[-1] + len(row) + 1)
    span = edit.span
    start = starts[span.line - 1] + span.column - 1
    end = starts[span.end_line - 1] + span.end_column - 1
    return min(start, len(text)), min(end, len(text)), edit.replacement


def _overlap(edit: tuple[int, int, str], other: tuple[int, int, str]) -> bool:
    """Return whether two edits share characters, or insert at the same place."""
    if edit[:2] == other[:2]:
        return True
    return edit[0] < other[1] and other[0] < edit[1]
