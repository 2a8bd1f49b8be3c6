"""Two aligned call trees as the rows of a page, marked as same, changed, or present in only one trace."""

from __future__ import annotations

from collections.abc import Iterator

from ntp_dsl.traces.comparison.alignment import Level
from ntp_dsl.traces.comparison.comparison import Comparison
from ntp_dsl.traces.page.document import NO_ROW, PageRow
from ntp_dsl.traces.schema import ROOT

Match = tuple[int | None, int | None, int]  # call of the first trace, of the second, depth


def page_rows(comparison: Comparison) -> list[PageRow]:
    """Return the rows in order of execution."""
    changed = {
        (each.a, each.b) if (each.a, each.b) != (None, None) else (each.caller_a, each.caller_b)
        for each in comparison.divergences
    }
    rows: list[PageRow] = []
    open_rows: list[int] = []
    for a, b, depth in _matches(comparison):
        _close(rows, open_rows, depth)
        mark = (
            "only b" if a is None else "only a" if b is None else "changed" if (a, b) in changed else "same"
        )
        parent = open_rows[-1] if open_rows else NO_ROW
        open_rows.append(len(rows))
        rows.append(PageRow(a, b, depth, mark, parent))
    _close(rows, open_rows, 0)
    for row in reversed(rows):
        row.unchanged = row.unchanged and row.mark == "same"
        if row.parent != NO_ROW and not row.unchanged:
            rows[row.parent].unchanged = False
    return rows


def _close(rows: list[PageRow], open_rows: list[int], depth: int) -> None:
    """End the open rows at this depth or below."""
    while len(open_rows) > depth:
        rows[open_rows.pop()].end = len(rows)


def _matches(comparison: Comparison) -> Iterator[Match]:
    levels = {(level.caller_a, level.caller_b): level for level in comparison.levels}
    waiting = _pairs(levels.get((ROOT, ROOT)), 0)
    while waiting:
        a, b, depth = waiting.pop()
        yield a, b, depth
        if a is not None and b is not None:
            waiting += _pairs(levels.get((a, b)), depth + 1)
        else:
            waiting += _unmatched(comparison, a, b, depth + 1)


def _pairs(level: Level | None, depth: int) -> list[Match]:
    """Return the pairs of a level in reverse, as a stack."""
    return [(a, b, depth) for a, b in reversed(level.pairs)] if level else []


def _unmatched(comparison: Comparison, a: int | None, b: int | None, depth: int) -> list[Match]:
    """Return the children of a call that only one trace has, in reverse."""
    if a is not None:
        return [(call.id, None, depth) for call in reversed(comparison.a.children(a))]
    assert b is not None
    return [(None, call.id, depth) for call in reversed(comparison.b.children(b))]
