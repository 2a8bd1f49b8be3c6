"""Which facts are seen: right without noise, calibrated with it, and told by geometry alone."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from functools import cache
from math import erf, sqrt
from typing import NamedTuple

import numpy as np
import pytest
from films import AWAY, cube
from one_core_samples import the_core

from ntp_dsl.core.perception import grounding
from ntp_dsl.core.perception.features import NEAR, bodies, near_pairs
from ntp_dsl.core.perception.grounding import ground, ground_all
from ntp_dsl.core.pretraining.grounding_data import SHAKEN
from ntp_dsl.core.pretraining.scenes import moments, shaken
from ntp_dsl.semantics import predicates
from ntp_dsl.semantics.graded import GRADED, Graded
from ntp_dsl.semantics.observation import Observation

FRESH = 20_261_129  # no seed of a pretraining: those are small
SCENES = 80
HAND = "hand"
OF_PAIRS = {"on": predicates.on, "covers": predicates.covers, "in": predicates.inside}
NAMES = [*OF_PAIRS, "holding", "empty", "clear", "above"]
NOISES = [0.0, 0.004, 0.008, 0.012, 0.02]  # [m]
WRONG, WRONG_ON, ECE = 0.01, 0.015, 0.03


@cache
def fresh() -> list[Observation]:
    """Return made-up moments that no training had, some of them shaken so that facts are close calls."""
    found = []
    for number in range(SCENES):
        rng = np.random.default_rng((FRESH, number))
        found += [shaken(each, rng) if rng.random() < SHAKEN else each for each in moments(rng)]
    return found


def seen_with(truth: Observation, sigma: float, rng: np.random.Generator) -> Observation:
    if not sigma:
        return truth
    positions = {
        name: tuple((np.array(at) + rng.normal(0, sigma, 3)).tolist()) for name, at in truth.positions.items()
    }
    return replace(truth, positions=positions, deviations=dict.fromkeys(positions, sigma))


class Moment(NamedTuple):
    """A moment as it is observed, and as it is graded."""

    observation: Observation
    graded: Graded

    def chance(self, name: str, *arguments: str) -> float:
        return float(GRADED[name](self, *arguments))


def seen_facts(truth: Observation, seen: Observation) -> Iterator[tuple[str, float, bool]]:
    """Yield the facts that the network is asked for: how probably they hold, and whether they do."""
    moment = Moment(seen, ground(the_core().grounding, seen))
    b = bodies(seen)
    for i, j in zip(*near_pairs(b), strict=True):
        pair = b.names[i], b.names[j]
        for name, true in OF_PAIRS.items():
            yield name, moment.chance(name, *pair), true(truth, *pair)
    for obj in truth.objects:
        if truth.closed and obj.movable:
            yield "holding", moment.chance("holding", obj.name), predicates.holding(truth, obj.name)
        yield "clear", moment.chance("clear", obj.name), predicates.clear(truth, obj.name)
        yield "above", moment.chance("above", HAND, obj.name), predicates.above(truth, HAND, obj.name)
    yield "empty", moment.chance("empty", HAND), predicates.empty(truth, HAND)


@cache
def outcomes(sigma: float) -> dict[str, np.ndarray]:
    """Return, by predicate, probabilities and truth values, (facts, 2)."""
    rng = np.random.default_rng(FRESH)
    rows: dict[str, list[tuple[float, float]]] = {}
    for truth in fresh():
        for name, chance, true in seen_facts(truth, seen_with(truth, sigma, rng)):
            rows.setdefault(name, []).append((chance, float(true)))
    return {name: np.array(found) for name, found in rows.items()}


def calibration_error(rows: np.ndarray) -> float:
    bins = np.minimum((rows[:, 0] * 10).astype(int), 9)
    parts = [rows[bins == index] for index in range(10)]
    return sum(
        abs(part[:, 0].mean() - part[:, 1].mean()) * len(part) / len(rows) for part in parts if len(part)
    )


@pytest.mark.parametrize("name", NAMES)
def test_facts_are_seen_rightly_without_noise(name: str) -> None:
    rows = outcomes(0.0)[name]
    assert rows[:, 1].any() and not rows[:, 1].all() and len(rows) > 300
    assert ((rows[:, 0] > 0.5) != (rows[:, 1] > 0.5)).mean() <= (WRONG_ON if name == "on" else WRONG)


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("sigma", NOISES)
def test_probabilities_are_calibrated(name: str, sigma: float) -> None:
    assert calibration_error(outcomes(sigma)[name]) <= ECE


def test_probabilities_are_probabilities() -> None:
    for sigma in NOISES:
        for rows in outcomes(sigma).values():
            assert rows[:, 0].min() >= 0 and rows[:, 0].max() <= 1


# What they do not depend on


def told(graded: Graded, names: dict[str, str]) -> dict[object, float]:
    found: dict[object, float] = {"full": float(graded.full)}
    for (a, b), chances in graded.contacts.items():
        for index, chance in enumerate(chances):
            found[index, names[a], names[b]] = float(chance)
    for kind in ("held", "hovered", "covered"):
        found |= {(kind, names[name]): float(chance) for name, chance in getattr(graded, kind).items()}
    return found


def assert_alike(some: dict[object, float], others: dict[object, float]) -> None:
    assert some.keys() == others.keys()
    assert max((abs(some[key] - others[key]) for key in some), default=0.0) < 1e-5


@pytest.mark.parametrize("sigma", [0.0, 0.008])
def test_neither_order_nor_names_of_objects_matter(sigma: float) -> None:
    rng = np.random.default_rng(1)
    for truth in fresh()[::7]:
        seen = seen_with(truth, sigma, rng)
        own = {obj.name: obj.name for obj in seen.objects}
        plain = told(ground(the_core().grounding, seen), own)
        order = tuple(rng.permutation(len(seen.objects)).tolist())
        assert_alike(told(ground(the_core().grounding, seen.permuted(order)), own), plain)
        names = {name: f"z{index}" for name, index in zip(own, order, strict=True)}
        other = told(ground(the_core().grounding, renamed(seen, names)), {v: k for k, v in names.items()})
        assert_alike(other, plain)


def renamed(seen: Observation, names: dict[str, str]) -> Observation:
    return replace(
        seen,
        objects=tuple(replace(obj, name=names[obj.name], type="Other") for obj in seen.objects),
        positions={names[name]: at for name, at in seen.positions.items()},
        orientations={names[name]: turn for name, turn in seen.orientations.items()},
        deviations={names[name]: each for name, each in seen.deviations.items()},
    )


def test_where_the_scene_lies_on_the_table_does_not_matter() -> None:
    for truth in fresh()[::11]:
        shift = np.array([0.07, -0.04, 0.0])
        moved = replace(
            truth,
            positions={n: tuple((np.array(at) + shift).tolist()) for n, at in truth.positions.items()},
            gripper=tuple((np.array(truth.gripper) + shift).tolist()),
        )
        own = {obj.name: obj.name for obj in truth.objects}
        assert_alike(*(told(ground(the_core().grounding, each), own) for each in (truth, moved)))


@pytest.mark.parametrize("height", [0.03, 0.05, 0.07])
@pytest.mark.parametrize("aside", [0.0, 0.0001, 0.003, 0.01])
def test_an_object_is_held_wherever_the_hand_is_closed_about_it(height: float, aside: float) -> None:
    """Worlds grasp at other heights, and to other fractions of a millimetre."""
    jar = replace(cube("a"), size=(0.05, 0.05, height), shape="cylinder")
    for rise in np.linspace(-0.01, 0.02, 7).tolist():
        for lifted in (0.0, 0.15):
            at = (0.5, 0.1, height / 2 + lifted)
            hand = (0.5 + aside, 0.1, at[2] + rise)
            graded = ground(the_core().grounding, Observation((jar,), {"a": at}, hand, closed=True))
            assert graded.held["a"] > 0.9, (height, aside, rise, lifted)
    beyond = (0.5, 0.1, height + 0.06)
    seen = Observation((jar,), {"a": (0.5, 0.1, height / 2)}, beyond, closed=True)
    assert seen.held is None and ground(the_core().grounding, seen).held["a"] < 0.1


# What is asked


def two_cubes(gap: float, sigma: float = 0.0, height: float = 0.025) -> Observation:
    """Return two cubes whose sides are so far apart."""
    positions = {"a": (0.5, 0.0, height), "b": (0.55 + gap, 0.0, 0.025)}
    deviations = dict.fromkeys(positions, sigma) if sigma else {}
    return Observation((cube("a"), cube("b")), positions, AWAY, closed=False, deviations=deviations)


@pytest.mark.parametrize("sigma", [0.0, 0.002, 0.008])
def test_facts_of_far_pairs_are_not_asked(sigma: float, monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[int] = []
    chances = grounding._chances
    monkeypatch.setattr(
        grounding, "_chances", lambda net, rows: asked.append(len(rows)) or chances(net, rows)
    )
    doubt = NEAR + 4 * sqrt(2) * sigma
    near, far = two_cubes(doubt - 0.001, sigma), two_cubes(doubt + 0.001, sigma)
    assert set(ground(the_core().grounding, near).contacts) == {("a", "b"), ("b", "a")}
    before = sum(asked)
    graded = ground(the_core().grounding, far)
    assert not graded.contacts and sum(asked) - before == before - 2, "two pairs are asked less"
    assert Moment(far, graded).chance("on", "a", "b") == 0.0


def test_the_number_of_pairs_grows_with_the_objects_and_not_with_their_square() -> None:
    counts = {}
    for count in (16, 64):
        places = {f"o{i}": (0.2 + 0.1 * (i % 8), -0.4 + 0.1 * (i // 8), 0.025) for i in range(count)}
        seen = Observation(tuple(map(cube, places)), places, AWAY, closed=False)
        counts[count] = len(near_pairs(bodies(seen))[0])
    assert counts[64] <= 4 * counts[16] == 0


def test_true_facts_are_always_asked() -> None:
    for truth in fresh():
        b = bodies(truth)
        asked = {(b.names[i], b.names[j]) for i, j in zip(*near_pairs(b), strict=True)}
        for a in b.names:
            for c in b.names:
                if a != c and (a, c) not in asked:
                    assert not any(true(truth, a, c) for true in OF_PAIRS.values()), (a, c)


def test_moments_that_are_seen_together_are_seen_as_each_alone() -> None:
    """Two objects that have not moved are asked of once; no answer hangs on which moments come along."""
    core = the_core().grounding
    for number in range(5):
        seen = moments(np.random.default_rng((FRESH, number)))
        seen += [replace(each, gripper=(0.3, 0.2, 0.4)) for each in seen]
        for together, each in zip(ground_all(core, seen), seen, strict=True):
            alone = ground(core, each)
            assert together.contacts.keys() == alone.contacts.keys()
            for pair, chances in alone.contacts.items():
                assert together.contacts[pair] == pytest.approx(chances, abs=1e-5)
            assert together.held == pytest.approx(alone.held, abs=1e-5)
            assert together.hovered == pytest.approx(alone.hovered, abs=1e-5)
            assert together.covered == pytest.approx(alone.covered, abs=1e-5)


def test_an_empty_scene_has_no_facts() -> None:
    seen = Observation((), {}, AWAY, closed=False)
    graded = ground(the_core().grounding, seen)
    assert not graded.contacts and not graded.hovered and graded.full == 0.0


def test_a_lost_object_has_no_facts() -> None:
    seen = two_cubes(0.0, height=0.075)
    lost = replace(seen, positions={"a": seen.positions["a"]})
    moment = Moment(lost, ground(the_core().grounding, lost))
    assert (
        moment.chance("on", "a", "b") == moment.chance("clear", "b") == moment.chance("present", "b") == 0.0
    )


# Doubt


def stacked(offset: float, sigma: float) -> Observation:
    positions = {"a": (0.5 + offset, 0.0, 0.075), "b": (0.5, 0.0, 0.025)}
    deviations = dict.fromkeys(positions, sigma) if sigma else {}
    return Observation((cube("a"), cube("b")), positions, AWAY, closed=False, deviations=deviations)


def chance_of_on(offset: float, sigma: float) -> float:
    return float(ground(the_core().grounding, stacked(offset, sigma)).contacts["a", "b"][0])


@pytest.mark.parametrize("offset, holds", [(0.008, True), (0.012, True), (0.02, False), (0.022, False)])
def test_the_wider_the_stated_deviation_the_less_certain_is_a_borderline_fact(
    offset: float, holds: bool
) -> None:
    """A cube lies off the middle of another: `on` means within 15 mm."""
    chances = [chance_of_on(offset, sigma) for sigma in (0.0, 0.002, 0.004)]
    assert (chances[0] > 0.5) is holds
    sure = [abs(each - 0.5) for each in chances]
    assert sure[0] > 0.4 and sure[0] - max(sure[1:]) > 0.003 and sure[0] - sure[-1] > 0.01


def test_what_is_hardly_seen_is_believed_as_it_mostly_is() -> None:
    """Of cubes that seem to lie on one another, most are centred."""
    for offset in (0.008, 0.022):
        chances = [chance_of_on(offset, sigma) for sigma in (0.004, 0.008, 0.012)]
        assert 0.5 < chances[-1] < 0.95
        assert abs(chances[-1] - 0.75) < abs(chances[0] - 0.75)


def test_certain_facts_stay_certain_under_a_little_doubt() -> None:
    for sigma in (0.0, 0.002):
        assert chance_of_on(0.0, sigma) > 0.95
        assert chance_of_on(0.04, sigma) < 0.05


def test_doubt_is_near_to_what_geometry_says() -> None:
    """Across the edge of `on`, a probability follows the distribution of the true offset."""
    sigma = 0.002
    for offset in np.linspace(0.009, 0.021, 7):
        expected = 0.5 * (1 + erf((0.015 - offset) / (sqrt(2) * sigma) / sqrt(2)))
        assert chance_of_on(float(offset), sigma) == pytest.approx(expected, abs=0.3), offset


def test_a_probability_falls_as_an_object_slides_off() -> None:
    for sigma in (0.0, 0.004, 0.008):
        chances = [chance_of_on(offset, sigma) for offset in np.linspace(0, 0.045, 10)]
        assert all(a >= b - 0.05 for a, b in zip(chances, chances[1:], strict=False)), (sigma, chances)
        assert chances[0] > 0.5 > chances[-1]
