"""How well an element fits a placement: people aim at the middle of where it holds, or anywhere there.

Where an element holds is found by trying places beside the object's, so that it works for any predicate.
Only directions along the table count: how high an object lies is up to what is below.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ntp_dsl.semantics.free_space import load
from ntp_dsl.semantics.observation import Observation
from ntp_dsl.semantics.state import State

RINGS = np.array([0.003, 0.006, 0.01, 0.015, 0.02, 0.03, 0.04])  # radii at which places are tried [m]
AROUND = 12  # places on each of them
CARE = 0.004  # with which people's hands aim, standard along each axis [m]
FARTHEST = 3.0  # standard deviations of where an object is seen
CARELESS = 0.1  # of all placements: anywhere an element holds

Perceive = Callable[[Sequence[Observation]], Sequence[State]]
Offset = tuple[float, float]  # along the table [m]


def _offsets() -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the places that are tried, (P, 2) [m], and the area that each stands for, (P,) [m²]."""
    angles = 2 * np.pi * np.arange(AROUND) / AROUND
    ways = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    between = (RINGS[1:] + RINGS[:-1]) / 2
    bounds = np.array([RINGS[0] / 2, *between, RINGS[-1]])
    areas = np.pi * np.diff(bounds**2) / AROUND
    offsets = np.concatenate([np.zeros((1, 2)), *(radius * ways for radius in RINGS)])
    return offsets, np.concatenate([[np.pi * bounds[0] ** 2], np.repeat(areas, AROUND)])


OFFSETS, AREAS = _offsets()


@dataclass(frozen=True)
class Places:
    """The states that would be if an object had been put down at each of `OFFSETS` from where it lies."""

    states: Sequence[State]
    care: float  # standard deviation of where it is aimed and seen, along each axis [m]

    def likelihood(self, holds: Callable[[State], bool]) -> float | None:
        """Return about how densely objects are put here so that something holds [1/m²]; 0 where it does not.

        It is a mixture of a normal distribution about the middle of where it holds and of a uniform one over
        that. None for what holds at one of the farthest places, as in a bowl: its middle cannot be found, and
        things are put anywhere there.
        """
        inside = np.array([holds(state) for state in self.states])
        if not inside[0]:
            return 0.0
        if inside[-AROUND:].any():
            return None
        area = float(AREAS[inside].sum())
        middle = (AREAS[inside, None] * OFFSETS[inside]).sum(axis=0) / area
        peak = 1 / (2 * np.pi * self.care**2)
        careful = peak * np.exp(-0.5 * float(middle @ middle) / self.care**2)
        return float((1 - CARELESS) * careful + CARELESS / area)

    def certainty(self, holds: Callable[[State], bool], deviation: float) -> float:
        """Return how probably something that is seen to hold does so where the object really lies.

        Args:
            deviation: of what is seen, standard along each axis [m].
        """
        inside = np.array([holds(state) for state in self.states])
        weights = AREAS * np.exp(-0.5 * (OFFSETS**2).sum(axis=1) / deviation**2)
        return float(weights[inside].sum() / weights.sum())

    def nearby(self, deviation: float) -> Iterator[tuple[Offset, State]]:
        """Yield where the object may lie as far as can be seen, the nearest first, and the state then.

        Args:
            deviation: of what is seen, standard along each axis [m].
        """
        for (dx, dy), state in zip(OFFSETS.tolist(), self.states, strict=True):
            if np.hypot(dx, dy) <= FARTHEST * deviation:
                yield (dx, dy), state


def places(seen: State, item: str, perceive: Perceive) -> Places:
    """Return the states that would be if an object lay elsewhere, with what lies in it."""
    looked = seen.observation
    moved = {item, *load(looked, item)}

    def shifted(offset: NDArray[np.float64]) -> Observation:
        dx, dy = offset.tolist()
        positions = {
            n: (x + dx, y + dy, z) if n in moved else (x, y, z) for n, (x, y, z) in looked.positions.items()
        }
        return replace(looked, positions=positions)

    care = float(np.hypot(CARE, looked.deviations.get(item, 0.0)))
    return Places(perceive([shifted(each) for each in OFFSETS]), care)
