"""Probabilities are held against what came true."""

from __future__ import annotations

from random import Random

from hypothesis import given
from hypothesis import strategies as st

from ntp_dsl.traces.report.reliability import Reliability

CHANCES = st.lists(st.tuples(st.floats(0, 1), st.booleans()), min_size=1)


@given(CHANCES, st.randoms())
def test_the_order_of_what_was_found_does_not_matter(rows: list[tuple[float, bool]], random: Random) -> None:
    shuffled = sorted(rows, key=lambda _: random.random())
    assert abs(Reliability.of(rows).error - Reliability.of(shuffled).error) < 1e-9
    assert 0 <= Reliability.of(rows).error <= 1


def test_who_is_as_often_right_as_sure_has_no_error() -> None:
    rows = [(0.25, number % 4 == 0) for number in range(40)] + [
        (0.75, number % 4 != 0) for number in range(40)
    ]
    assert Reliability.of(rows).error == 0
    assert Reliability.of([(1.0, False)]).error == 1
    assert Reliability.of([(0.9, True), (0.1, False)]).error < 0.11
