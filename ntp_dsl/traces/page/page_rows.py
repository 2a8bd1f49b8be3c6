"""Both trees as the rows of a page, with what is the same, changed, or only in one."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from ntp_dsl.traces.comparison.alignment import Level
from ntp_dsl.traces.comparison.comparison import Comparison
from ntp_dsl.traces.schema import ROOT

Place = tuple[int | None, int | None, int]  # call of the first trace, of the second, depth


def rows(comparison: Comparison) -> list[dict[str, Any]]:
    """In the order of execution. `end`: the row after all below; `above`: the caller's row, or −1.

    `whole` is a row below which, itself included, nothing differs.
    """
    changed = {each.a for each in comparison.divergences if each.a is not None}
    found: list[dict[str, Any]] = []
    open_rows: list[int] = []
    for a, b, depth in _places(comparison):
        _close(found, open_rows, depth)
        mark = "only b" if a is None else "only a" if b is None else "changed" if a in changed else "same"
        above = open_rows[-1] if open_rows else -1
        row = {"a": a, "b": b, "depth": depth, "mark": mark, "end": 0, "above": above, "whole": True}
        open_rows.append(len(found))
        found.append(row)
    _close(found, open_rows, 0)
    for row in reversed(found):
        row["whole"] = row["whole"] and row["mark"] == "same"
        if row["above"] >= 0 and not row["whole"]:
            found[row["above"]]["whole"] = False
    return found


def _close(found: list[dict[str, Any]], open_rows: list[int], depth: int) -> None:
    """What stands at this depth or below ends before the row that comes."""
    while len(open_rows) > depth:
        found[open_rows.pop()]["end"] = len(found)


def _places(comparison: Comparison) -> Iterator[Place]:
    levels = {(level.caller_a, level.caller_b): level for level in comparison.levels}
    waiting = _pairs(levels.get((ROOT, ROOT)), 0)
    while waiting:
        a, b, depth = waiting.pop()
        yield a, b, depth
        if a is not None and b is not None:
            waiting += _pairs(levels.get((a, b)), depth + 1)
        else:
            waiting += _left_over(comparison, a, b, depth + 1)


def _pairs(level: Level | None, depth: int) -> list[Place]:
    """The last first, to be taken from the end."""
    return [(a, b, depth) for a, b in reversed(level.pairs)] if level else []


def _left_over(comparison: Comparison, a: int | None, b: int | None, depth: int) -> list[Place]:
    if a is not None:
        return [(call.id, None, depth) for call in reversed(comparison.a.children(a))]
    assert b is not None
    return [(None, call.id, depth) for call in reversed(comparison.b.children(b))]
