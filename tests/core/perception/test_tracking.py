"""Looks: what rests is averaged, what is held rides in the hand, what has moved is seen at once."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from films import AWAY, as_vector, look
from hypothesis import given, settings
from hypothesis import strategies as st

from ntp_dsl.core.perception.tracking import FLOOR, GATE, Tracker
from ntp_dsl.semantics.geometry import Vector
from ntp_dsl.semantics.observation import Observation

PLACE = np.array([0.5, 0.1, 0.025])
SIGMA = 0.004


def looks_at(
    place: np.ndarray, count: int, rng: np.random.Generator, sigma: float = SIGMA
) -> list[Observation]:
    return [look({"b": as_vector(place + rng.normal(0, sigma, 3))}, sigma) for _ in range(count)]


def error(seen: Observation, place: np.ndarray) -> float:
    return float(np.abs(np.array(seen.positions["b"]) - place).max())


def test_looks_without_noise_are_taken_as_they_are() -> None:
    tracker = Tracker()
    for index in range(5):
        seen = look({"b": (0.5 + 0.1 * index, 0.0, 0.02)})
        assert tracker.update(seen) is seen


def test_an_object_at_rest_is_the_mean_of_its_looks() -> None:
    rng = np.random.default_rng(1)
    tracker, seen = Tracker(), looks_at(PLACE, 12, rng)
    tracked = [tracker.update(each) for each in seen]
    for count, each in enumerate(tracked, start=1):
        mean = np.mean([one.positions["b"] for one in seen[:count]], axis=0)
        assert np.allclose(each.positions["b"], mean, atol=1e-9)
        assert each.deviations["b"] == pytest.approx(max(SIGMA / np.sqrt(count), FLOOR * SIGMA))


def test_the_error_shrinks_with_the_looks() -> None:
    first, last = [], []
    for seed in range(40):
        tracker = Tracker()
        tracked = [tracker.update(each) for each in looks_at(PLACE, 16, np.random.default_rng(seed))]
        first.append(error(tracked[0], PLACE))
        last.append(error(tracked[-1], PLACE))
    assert np.mean(last) < 0.4 * np.mean(first)


@settings(max_examples=50, deadline=None)
@given(st.lists(st.floats(0.001, 0.02), min_size=2, max_size=12), st.integers(0, 1000))
def test_exacter_looks_count_for_more_and_no_deviation_is_below_the_floor(
    sigmas: list[float], seed: int
) -> None:
    rng = np.random.default_rng(seed)
    tracker, places = Tracker(), []
    for sigma in sigmas:
        place = PLACE + np.clip(rng.normal(0, sigma, 3), -2 * sigma, 2 * sigma)
        places.append(place)
        seen = tracker.update(look({"b": as_vector(place)}, sigma))
        assert seen.deviations["b"] >= FLOOR * sigma
        assert seen.deviations["b"] <= sigma + 1e-12
    weights = np.array(sigmas) ** -2
    assert np.allclose(seen.positions["b"], np.average(places, axis=0, weights=weights), atol=1e-9)


def test_a_constant_error_is_never_trusted_away() -> None:
    tracker = Tracker()
    for _ in range(200):
        seen = tracker.update(look({"b": as_vector(PLACE + 0.004)}, SIGMA))
    assert seen.deviations["b"] == FLOOR * SIGMA


def test_what_has_moved_is_seen_where_it_is_now() -> None:
    rng = np.random.default_rng(0)
    tracker = Tracker()
    for each in looks_at(PLACE, 20, rng):
        tracker.update(each)
    there = PLACE + [0.05, 0, 0]
    seen = tracker.update(looks_at(there, 1, rng)[0])
    assert error(seen, there) < 4 * SIGMA
    assert seen.deviations["b"] == pytest.approx(SIGMA)


@pytest.mark.parametrize("sigmas", [2, 3])
def test_what_moved_by_less_than_the_gate_is_found_out_by_more_looks(sigmas: float) -> None:
    rng = np.random.default_rng(4)
    tracker = Tracker()
    for each in looks_at(PLACE, 40, rng):
        tracker.update(each)
    there = PLACE + [sigmas * SIGMA, 0, 0]
    for each in looks_at(there, 40, rng):
        seen = tracker.update(each)
    assert error(seen, there) < 0.6 * SIGMA


@pytest.mark.parametrize("share, moved", [(0.5, False), (0.9, False), (1.1, True), (3.0, True)])
def test_the_gate_is_as_wide_as_it_says(share: float, moved: bool) -> None:
    tracker = Tracker()
    tracker.update(look({"b": as_vector(PLACE)}, SIGMA))
    off = share * GATE * np.hypot(SIGMA, SIGMA)
    seen = tracker.update(look({"b": as_vector(PLACE + [off, 0, 0])}, SIGMA))
    assert (error(seen, PLACE + [off, 0, 0]) < 1e-9) is moved


def test_what_is_held_is_averaged_in_the_hand() -> None:
    rng = np.random.default_rng(2)
    tracker = Tracker()
    for step in range(20):
        hand = np.array(AWAY) + [0, 0.03 * step, 0]
        seen = held(hand + [0.001, 0.0, -0.005], hand, rng)
        tracked = tracker.update(seen)
        true = hand + [0.001, 0.0, -0.005]
    assert error(tracked, true) < SIGMA
    assert tracked.deviations["b"] == pytest.approx(max(FLOOR, 20**-0.5) * SIGMA)


def held(place: np.ndarray, hand: np.ndarray, rng: np.random.Generator) -> Observation:
    seen = look({"b": as_vector(place + rng.normal(0, SIGMA, 3))}, SIGMA, as_vector(hand), closed=True)
    assert seen.held == "b"
    return seen


def test_what_was_put_down_is_looked_at_anew() -> None:
    rng = np.random.default_rng(3)
    tracker = Tracker()
    hand = np.array(AWAY)
    for _ in range(10):
        tracker.update(held(hand, hand, rng))
    seen = tracker.update(look({"b": as_vector(hand)}, SIGMA, as_vector(hand)))
    assert seen.deviations["b"] == pytest.approx(SIGMA)
    assert seen.positions["b"] == pytest.approx(as_vector(hand))


def test_an_object_out_of_sight_is_forgotten() -> None:
    tracker = Tracker()
    far = {"a": (0.3, 0.3, 0.02)}
    for _ in range(5):
        tracker.update(look({**far, "b": as_vector(PLACE)}, SIGMA))
    without = look(far, SIGMA)
    assert set(tracker.update(without).positions) == {"a"}
    again = tracker.update(look({**far, "b": as_vector(PLACE)}, SIGMA))
    assert again.deviations["b"] == pytest.approx(SIGMA)


def test_each_object_has_a_doubt_of_its_own() -> None:
    """Of one the deviation is stated, of the other none: it is known exactly."""
    tracker = Tracker()
    places: dict[str, Vector] = {"a": (0.3, 0.3, 0.02), "b": as_vector(PLACE)}
    for _ in range(3):
        seen = tracker.update(look(places, {"b": SIGMA}))
    assert set(seen.deviations) == {"b"} and seen.positions["a"] == places["a"]


def test_nothing_else_of_a_look_is_changed() -> None:
    seen = look({"b": as_vector(PLACE)}, SIGMA)
    tracked = Tracker().update(seen)
    assert replace(tracked, positions=seen.positions, deviations=seen.deviations) == seen
