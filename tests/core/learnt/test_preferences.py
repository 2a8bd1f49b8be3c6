"""What many choices have in common is found, and nothing where there is nothing."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ntp_dsl.core.learnt.preferences import (
    Choice,
    Column,
    Preference,
    Transform,
    columns_of,
    preferred,
)
from ntp_dsl.core.learnt.quantities import Quantity

COLUMNS = tuple(Column(Quantity(name)) for name in "abcdefgh")
A, B, C = COLUMNS[:3]


def choices(count: int, weights: dict[Column, float], seed: int, calls: int = 5) -> list[Choice]:
    """Return choices of the call whose weighted sum is largest."""
    rng = np.random.default_rng(seed)
    found = []
    for _ in range(count):
        offers = [
            dict(zip(COLUMNS, rng.normal(size=len(COLUMNS)).tolist(), strict=True)) for _ in range(calls)
        ]
        sums = [sum(weight * offer[name] for name, weight in weights.items()) for offer in offers]
        found.append(Choice(offers, int(np.argmax(sums))))
    return found


def foreseen(preference: Preference, some: list[Choice]) -> float:
    """Return the share of choices in which the call with the largest score is the one that was made."""
    hits = [int(np.argmax([preference.score(each) for each in one.calls])) == one.chosen for one in some]
    return sum(hits) / len(hits)


@settings(max_examples=20, deadline=None)
@given(
    st.dictionaries(st.sampled_from(COLUMNS), st.sampled_from([-2.0, -1.0, 1.0, 2.0]), min_size=1, max_size=3)
)
def test_a_weighted_sum_is_found_and_holds_of_new_choices(weights: dict[Column, float]) -> None:
    found = preferred(choices(80, weights, seed=1))
    assert weights.keys() <= {each.column for each in found.terms}
    assert foreseen(found, choices(200, weights, seed=2)) > 0.9


@pytest.mark.parametrize("seed", range(5))
def test_choices_by_chance_show_no_preference(seed: int) -> None:
    rng = np.random.default_rng(seed)
    some = [Choice(each.calls, int(rng.integers(5))) for each in choices(60, {A: 1.0}, seed)]
    assert preferred(some).terms == ()


def test_few_choices_are_enough_for_what_is_simple() -> None:
    found = preferred(choices(15, {C: -1.0}, seed=4, calls=4))
    assert [(each.column, each.weight < 0) for each in found.terms] == [(C, True)]


def test_the_order_of_the_calls_does_not_matter() -> None:
    some = choices(40, {A: 1.0, B: -1.0}, seed=3)
    turned = [Choice(each.calls[::-1], len(each.calls) - 1 - each.chosen) for each in some]
    terms = preferred(some).terms
    assert len(terms) == 2
    for one, other in zip(terms, preferred(turned).terms, strict=True):
        assert one.column == other.column and one.weight == pytest.approx(other.weight)


def test_where_there_was_no_choice_nothing_is_learnt() -> None:
    assert preferred([Choice([{A: 1.0}], 0)]).terms == preferred([]).terms == ()


def test_a_logarithm_is_offered_only_where_all_is_positive() -> None:
    """Zero grease has none, and would count as much as one."""
    grease = Quantity("grease", ("d",), is_declared=True)
    offers = [
        [columns_of([(grease, float(value), True)]) for value in values]
        for values in ([0, 1], [2, 1], [1, 3])
    ]
    found = preferred(
        [Choice(each, int(np.argmax([c[Column(grease)] for c in each]))) for each in offers * 9]
    )
    assert found.terms and all(each.column.transform is not Transform.LOG for each in found.terms)
    assert found.score(columns_of([(grease, 1.0, True)])) > found.score(columns_of([(grease, 0.0, True)]))


def test_a_ratio_is_found_by_logarithms() -> None:
    rng = np.random.default_rng(8)
    price, weight = Quantity("price", ("p",), is_declared=True), Quantity("weight", ("p",), is_declared=True)
    some = []
    for _ in range(120):
        pairs = rng.uniform(0.5, 8.0, size=(6, 2))
        calls = [columns_of([(price, float(p), True), (weight, float(w), True)]) for p, w in pairs]
        some.append(Choice(calls, int(np.argmax(pairs[:, 0] / pairs[:, 1]))))
    assert foreseen(preferred(some[:80]), some[80:]) > 0.9
