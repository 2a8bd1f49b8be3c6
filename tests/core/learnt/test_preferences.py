"""What many choices have in common is found, and nothing where there is nothing."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ntp_dsl.core.learnt.preferences import Choice, Preference, preferred

COLUMNS = ("a", "b", "c", "d", "e", "f", "g", "h")


def choices(count: int, weights: dict[str, float], seed: int, calls: int = 5) -> list[Choice]:
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
def test_a_weighted_sum_is_found_and_holds_of_new_choices(weights: dict[str, float]) -> None:
    found = preferred(choices(80, weights, seed=1))
    assert weights.keys() <= {each.column for each in found.terms}
    assert foreseen(found, choices(200, weights, seed=2)) > 0.9


@pytest.mark.parametrize("seed", range(5))
def test_choices_by_chance_show_no_preference(seed: int) -> None:
    rng = np.random.default_rng(seed)
    some = [Choice(each.calls, int(rng.integers(5))) for each in choices(60, {"a": 1.0}, seed)]
    assert preferred(some).terms == ()


def test_few_choices_are_enough_for_what_is_simple() -> None:
    found = preferred(choices(15, {"c": -1.0}, seed=4, calls=4))
    assert [(each.column, each.weight < 0) for each in found.terms] == [("c", True)]


def test_the_order_of_the_calls_does_not_matter() -> None:
    some = choices(40, {"a": 1.0, "b": -1.0}, seed=3)
    turned = [Choice(each.calls[::-1], len(each.calls) - 1 - each.chosen) for each in some]
    for one, other in zip(preferred(some).terms, preferred(turned).terms, strict=True):
        assert one.column == other.column and one.weight == pytest.approx(other.weight)


def test_where_there_was_no_choice_nothing_is_learnt() -> None:
    assert preferred([Choice([{"a": 1.0}], 0)]).terms == preferred([]).terms == ()
