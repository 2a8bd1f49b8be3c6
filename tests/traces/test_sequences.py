"""The common subsequence is in both sequences, in order, and longest where little differs."""

from __future__ import annotations

from functools import cache

import pytest
from hypothesis import given
from hypothesis import strategies as st

from ntp_dsl.traces.comparison.longest_common_subsequence import MAX_EDITS, common_subsequence

SHORT = st.lists(st.integers(0, 4), max_size=24)


def longest(xs: list[int], ys: list[int]) -> int:
    @cache
    def below(i: int, j: int) -> int:
        if i == len(xs) or j == len(ys):
            return 0
        if xs[i] == ys[j]:
            return 1 + below(i + 1, j + 1)
        return max(below(i + 1, j), below(i, j + 1))

    return below(0, 0)


def check(xs: list[int], ys: list[int]) -> None:
    pairs = common_subsequence(xs, ys)
    assert all(xs[i] == ys[j] for i, j in pairs)
    assert all(a < c and b < d for (a, b), (c, d) in zip(pairs, pairs[1:], strict=False))


@given(SHORT, SHORT)
def test_it_is_a_longest_one(xs: list[int], ys: list[int]) -> None:
    check(xs, ys)
    assert len(common_subsequence(xs, ys)) == longest(xs, ys)


@pytest.mark.parametrize("every", [2, 3, 50])
def test_beyond_many_edits_it_is_found_in_parts(every: int) -> None:
    xs = list(range(20 * MAX_EDITS))
    ys = [-x if x % every == 0 else x for x in xs]
    check(xs, ys)
    assert len(common_subsequence(xs, ys)) >= 0.9 * (len(xs) - len(xs) / every)


def test_disjoint_sequences_have_nothing_in_common() -> None:
    assert common_subsequence(list(range(2000)), list(range(-3000, -1))) == []
