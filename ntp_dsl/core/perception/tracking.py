"""What a robot makes of its looks: objects at rest are averaged over looks, held ones ride in the hand."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ntp_dsl.semantics.observation import Observation

GATE = 4.0  # standard deviations of a look, beyond which an object has moved
FLOOR = 0.25  # of a look's deviation, below which no average is trusted: an error may be constant


class Tracker:
    """The states of a scene that is looked at again and again. Looks without noise are taken as they are."""

    def __init__(self) -> None:
        self._looks: dict[str, _Looks] = {}

    def update(self, seen: Observation) -> Observation:
        """Return the state after one more look."""
        if not seen.deviations:
            return seen
        held = seen.held
        positions, deviations = dict(seen.positions), dict(seen.deviations)
        for name, at in seen.positions.items():
            sigma = seen.deviations.get(name, 0.0)
            if not sigma:
                continue
            place = np.array(at)
            in_hand = name == held
            origin = np.array(seen.gripper) if in_hand else np.zeros(3)
            looks = self._looks.get(name)
            if looks is None or looks.in_hand != in_hand or not looks.agrees(place - origin, sigma):
                looks = self._looks[name] = _Looks(in_hand)
            looks.add(place - origin, sigma)
            x, y, z = (looks.mean + origin).tolist()
            positions[name] = (x, y, z)
            deviations[name] = max(looks.deviation, FLOOR * sigma)
        for name in [name for name in self._looks if name not in seen.positions]:
            del self._looks[name]
        return replace(seen, positions=positions, deviations=deviations)


class _Looks:
    """The looks at one object since it last moved, in the world or in the hand."""

    def __init__(self, in_hand: bool) -> None:
        self.in_hand = in_hand
        self._weight, self._sum = 0.0, np.zeros(3)

    def add(self, place: np.ndarray, sigma: float) -> None:
        self._weight += sigma**-2
        self._sum += place * sigma**-2

    @property
    def mean(self) -> np.ndarray:
        return self._sum / self._weight

    @property
    def deviation(self) -> float:
        return float(self._weight**-0.5)

    def agrees(self, place: np.ndarray, sigma: float) -> bool:
        """Return whether a look may be at an object that has not moved."""
        doubt = GATE * float(np.hypot(sigma, self.deviation))
        return float(np.abs(place - self.mean).max()) < doubt
