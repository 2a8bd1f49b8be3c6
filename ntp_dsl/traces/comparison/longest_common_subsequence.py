"""What two sequences have in common, by Myers' algorithm (1986): fast where little differs."""

from __future__ import annotations

from collections.abc import Sequence

EDITS = 1000  # beyond so many it keeps what it has found, and begins anew where it got furthest
FEWER = 200  # from then on: the effort is their square
Places = list[tuple[int, int]]


def common(xs: Sequence[int], ys: Sequence[int]) -> Places:
    """Places of a common subsequence, in order; of a longest one where at most `EDITS` differ."""
    found: Places = []
    i = j = 0
    while i < len(xs) and j < len(ys):
        matches, (ahead_i, ahead_j) = _stretch(xs[i:], ys[j:], FEWER if i or j else EDITS)
        found += ((i + a, j + b) for a, b in matches)
        i, j = i + ahead_i, j + ahead_j
    return found


def _stretch(xs: Sequence[int], ys: Sequence[int], most: int) -> tuple[Places, tuple[int, int]]:
    """The matches of the beginnings, and how far these reach."""
    reach = {1: 0}  # on each diagonal, how far in xs with the edits so far
    history = []
    for edits in range(most + 1):
        history.append(reach.copy())
        for k in range(-edits, edits + 1, 2):
            i = reach[k + 1] if _down(reach, k, edits) else reach[k - 1] + 1
            while i < len(xs) and i - k < len(ys) and xs[i] == ys[i - k]:
                i += 1
            reach[k] = i
            if i >= len(xs) and i - k >= len(ys):
                return _matches(history, i, i - k), (len(xs), len(ys))
    inside = [k for k, i in reach.items() if i <= len(xs) and i - k <= len(ys) and k % 2 == most % 2]
    k = max(inside, key=lambda k: 2 * reach[k] - k)
    return _matches(history, reach[k], reach[k] - k), (reach[k], reach[k] - k)


def _down(reach: dict[int, int], k: int, edits: int) -> bool:
    """Whether a diagonal is entered by leaving out one of ys, rather than one of xs."""
    return k == -edits or (k != edits and reach[k - 1] < reach[k + 1])


def _matches(history: list[dict[int, int]], i: int, j: int) -> Places:
    """Back from (i, j) to the beginning. history[d]: what was reached with fewer than d edits."""
    pairs = []
    for edits in range(len(history) - 1, -1, -1):
        reach, k = history[edits], i - j
        before = k + 1 if _down(reach, k, edits) else k - 1
        from_i = reach[before]
        from_j = from_i - before
        while i > from_i and j > from_j:
            i, j = i - 1, j - 1
            pairs.append((i, j))
        i, j = from_i, from_j
    return pairs[::-1]
