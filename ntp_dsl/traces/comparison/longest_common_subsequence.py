"""Longest common subsequence by Myers' algorithm (1986), which is fast where little differs."""

from __future__ import annotations

from collections.abc import Sequence

MAX_EDITS = 1000  # then the matches so far are kept, and the search restarts from the furthest point
MAX_LATER_EDITS = 200  # after a restart: the effort is quadratic in them
Places = list[tuple[int, int]]


def common_subsequence(xs: Sequence[int], ys: Sequence[int]) -> Places:
    """Return the places of a common subsequence, in order; a longest one within `MAX_EDITS` edits."""
    matches: Places = []
    i = j = 0
    while i < len(xs) and j < len(ys):
        prefix, (ahead_i, ahead_j) = _match_prefixes(xs[i:], ys[j:], MAX_LATER_EDITS if i or j else MAX_EDITS)
        matches += ((i + a, j + b) for a, b in prefix)
        i, j = i + ahead_i, j + ahead_j
    return matches


def _match_prefixes(xs: Sequence[int], ys: Sequence[int], max_edits: int) -> tuple[Places, tuple[int, int]]:
    """Return the matches of two prefixes, and the length of the prefixes."""
    reach = {1: 0}  # on each diagonal, how far in xs with the edits so far
    history = []
    for edits in range(max_edits + 1):
        history.append(reach.copy())
        for k in range(-edits, edits + 1, 2):
            i = reach[k + 1] if _skips_y(reach, k, edits) else reach[k - 1] + 1
            while i < len(xs) and i - k < len(ys) and xs[i] == ys[i - k]:
                i += 1
            reach[k] = i
            if i >= len(xs) and i - k >= len(ys):
                return _matches(history, i, i - k), (len(xs), len(ys))
    inside = [k for k, i in reach.items() if i <= len(xs) and i - k <= len(ys) and k % 2 == max_edits % 2]
    k = max(inside, key=lambda k: 2 * reach[k] - k)
    return _matches(history, reach[k], reach[k] - k), (reach[k], reach[k] - k)


def _skips_y(reach: dict[int, int], k: int, edits: int) -> bool:
    """Whether a diagonal is entered by skipping an element of ys rather than of xs."""
    return k == -edits or (k != edits and reach[k - 1] < reach[k + 1])


def _matches(history: list[dict[int, int]], i: int, j: int) -> Places:
    """Trace the matches back from (i, j). history[d]: what was reached with fewer than d edits."""
    pairs = []
    for edits in range(len(history) - 1, -1, -1):
        reach, k = history[edits], i - j
        before = k + 1 if _skips_y(reach, k, edits) else k - 1
        from_i = reach[before]
        from_j = from_i - before
        while i > from_i and j > from_j:
            i, j = i - 1, j - 1
            pairs.append((i, j))
        i, j = from_i, from_j
    return pairs[::-1]
