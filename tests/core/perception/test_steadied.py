"""States of a demonstration: what rests is averaged, what is held is fixed in the hand."""

from __future__ import annotations

import numpy as np
import pytest
from films import film
from one_core_samples import shown

from ntp_dsl.core.perception.steadied import FLICKER, steadied
from ntp_dsl.demonstrations.demonstration import noisy

SIGMA = 0.003
PLACE = np.array([0.5, 0.1, 0.025])


def rms(values: np.ndarray) -> float:
    return float(np.sqrt((values**2).mean()))


def crowd(count: int) -> dict[str, np.ndarray]:
    return {f"b{index}": np.array([0.3 + 0.06 * index, 0.2, 0.025]) for index in range(count)}


@pytest.mark.parametrize("stated", [False, True])
def test_the_error_of_what_rests_shrinks_with_the_root_of_the_looks(stated: bool) -> None:
    paths = crowd(12)
    true = np.stack(list(paths.values()))
    errors = {}
    for frames in (6, 24, 96):
        found = [
            rms(
                steadied(film(paths, [False] * frames, noise=SIGMA, stated=stated, seed=seed)).positions
                - true
            )
            for seed in range(6)
        ]
        errors[frames] = rms(np.array(found))
        assert errors[frames] <= 1.5 * SIGMA / np.sqrt(frames)
    assert errors[6] > 1.5 * errors[24] > 2.2 * errors[96]


def test_the_deviation_is_that_of_the_mean() -> None:
    for frames in (6, 24, 96):
        found = steadied(film(crowd(6), [False] * frames, noise=SIGMA, stated=True)).deviations
        assert np.all(found >= SIGMA / np.sqrt(frames) - 1e-9)
        assert np.all(found <= 1.3 * SIGMA / np.sqrt(frames))


def test_without_noise_nothing_is_doubted_or_moved() -> None:
    shot = film({"b0": PLACE, "b1": PLACE + [0.1, 0, 0]}, [False] * 20)
    found = steadied(shot)
    assert np.allclose(found.positions, shot.positions, atol=1e-9)
    assert not found.deviations.any() and not found.observation(3).deviations


def carried(noise: float, stated: bool = True) -> tuple[np.ndarray, np.ndarray, np.ndarray, int, int]:
    """Return steadied and true positions of a cube that is carried 30 cm, the hand's, and when it closes."""
    rest, move = 15, 30
    way = np.linspace(0, 1, move)[:, None]
    end = PLACE + [0.1, -0.3, 0.0]
    arc = PLACE + way * (end - PLACE) + np.sin(np.pi * way) * [0, 0, 0.12]
    true = np.concatenate([np.tile(PLACE, (rest, 1)), arc, np.tile(end, (rest, 1))])
    hand = true + [0.002, 0.001, 0.01]
    closed = [False] * rest + [True] * move + [False] * rest
    shot = film({"b0": true}, closed, hand=hand, noise=noise, stated=stated)
    return steadied(shot).positions[:, 0], true, hand, rest, rest + move


@pytest.mark.parametrize("stated", [False, True])
def test_what_is_held_rides_with_the_hand(stated: bool) -> None:
    found, true, hand, begin, end = carried(SIGMA, stated)
    in_hand = (found - hand)[begin:end]
    assert np.ptp(in_hand, axis=0).max() < 1e-9
    assert rms((found - true)[begin:end]) < SIGMA / 2
    assert np.ptp(found[:begin], axis=0).max() < 1e-9
    assert np.ptp(found[end:], axis=0).max() < 1e-9


def test_an_object_that_falls_is_steadied_before_and_after() -> None:
    """No act of the hand lies between the two places."""
    high = PLACE + [0.0, 0.0, 0.1]
    for at in (8, 20, 33):
        true = np.concatenate([np.tile(high, (at, 1)), np.tile(PLACE, (40 - at, 1))])
        found = steadied(
            film({"b0": true, "b1": PLACE + [0.2, 0, 0]}, [False] * 40, noise=SIGMA, stated=True)
        )
        assert rms(found.positions[:, 0] - true) < SIGMA
        assert np.abs(found.positions[:, 0] - true).max() < 0.01


def test_an_object_that_is_carried_off_does_not_move_the_others() -> None:
    found, *_ = carried(SIGMA)
    shot = film(
        {"b0": found, "b1": PLACE + [0.2, 0, 0]}, [False] * 15 + [True] * 30 + [False] * 15, noise=SIGMA
    )
    assert np.ptp(steadied(shot).positions[:, 1], axis=0).max() < 1e-9


@pytest.mark.parametrize("rate", [10.0, 30.0, 100.0])
@pytest.mark.parametrize("state", [False, True])
def test_what_is_shorter_than_a_fifth_of_a_second_does_not_count(rate: float, state: bool) -> None:
    count = int(3 * rate)
    short, long = int(round(0.6 * FLICKER * rate)), int(round(1.6 * FLICKER * rate))
    for frames, events in ((max(1, short), 0), (long, 2)):
        closed = np.full(count, state)
        closed[count // 2 : count // 2 + frames] = not state
        found = steadied(film({"b0": PLACE}, closed, rate=rate))
        assert len(found.events) == events, (frames, rate)
        assert found.closed.any() == (state or events > 0)


def test_phases_are_the_frames_between_acts() -> None:
    closed = [False] * 10 + [True] * 10 + [False] * 10
    found = steadied(film({"b0": PLACE}, closed))
    assert found.events == (10, 20)
    assert found.phases((0, 30)) == [(0, 10), (10, 20), (20, 30)]
    assert found.phases((12, 20)) == [(12, 20)] and found.phases((5, 25)) == [(5, 10), (10, 20), (20, 25)]


@pytest.mark.parametrize("name", ["block_stacking", "seating", "table_cleanup"])
def test_a_noisy_demonstration_comes_near_to_the_true_one(name: str) -> None:
    _, true = shown(name, 0)
    seen = noisy(true, SIGMA, np.random.default_rng(0))
    movable = [index for index, obj in enumerate(true.objects) if obj.movable]
    raw, found = (
        rms((each - true.positions)[:, movable]) for each in (seen.positions, steadied(seen).positions)
    )
    assert found < 0.5 * raw


def test_a_steadied_demonstration_without_noise_is_nearly_itself() -> None:
    _, true = shown("block_stacking", 0)
    assert rms(steadied(true).positions - true.positions) < 0.004
