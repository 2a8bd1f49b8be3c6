"""How well an element fits what is shown: things are put where it asks, rather than where it just counts.

Where several elements explain the same, how far the object lies from the middle of all places at which the
element would hold tells them apart. The places are found by trial, so that it works for any predicate.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ntp_dsl.semantics.observation import Observation
from ntp_dsl.semantics.state import State

TRIED = np.array([0.04, 0.04, 0.02])  # how far places are tried from where the object is, each way [m]
PLACES = 96  # that are tried
CARE = 0.005  # with which things are put down, standard [m]
CARELESS = 0.3  # of all things, which are put down anywhere the element holds
OFFSETS = np.random.default_rng(15).uniform(-1, 1, (PLACES, 3)) * TRIED  # the same for all: (PLACES, 3) [m]

Perceive = Callable[[Sequence[Observation]], Sequence[State]]


@dataclass(frozen=True)
class Places:
    """The states that would be, if an object had been put down a little beside where it was."""

    here: State
    beside: Sequence[State]
    care: float  # standard deviation of where it is seen, and put [m]

    def likelihood(self, holds: Callable[[State], bool]) -> float:
        """Return how densely objects are put here by those who want something to hold, in 1/m³, or 0.

        They put them about the middle of all places where it holds, or, some of them, anywhere there.
        """
        if not holds(self.here):
            return 0.0
        inside = np.array([holds(state) for state in self.beside])
        middle = OFFSETS[inside].sum(axis=0) / (1 + inside.sum())
        volume = 8 * float(np.prod(TRIED)) * (1 + inside.sum()) / (1 + PLACES)
        peak = (2 * np.pi) ** -1.5 * self.care**-3
        careful = peak * np.exp(-0.5 * float(middle @ middle) / self.care**2)
        return float((1 - CARELESS) * careful + CARELESS / volume)


def places(seen: State, item: str, perceive: Perceive) -> Places:
    """Return the places about where an object is."""
    looked = seen.observation
    at = np.array(looked.positions[item])
    moved = [
        replace(looked, positions={**looked.positions, item: tuple((at + offset).tolist())})
        for offset in OFFSETS
    ]
    return Places(seen, perceive(moved), float(np.hypot(CARE, looked.deviations.get(item, 0.0))))
