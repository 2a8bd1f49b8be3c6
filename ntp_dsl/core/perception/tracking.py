"""What a robot makes of its looks: objects at rest are averaged over looks, held ones ride in the hand."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ntp_dsl.semantics.observation import Observation

GATE = 4.0  # standard deviations, beyond which an object has moved
LAST = (1, 2, 4, 8)  # how many of the last looks are compared with those before them
FLOOR = 0.1  # of a look's deviation, below which no average is trusted: an error may be constant


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
            if looks is None or looks.in_hand != in_hand:
                looks = self._looks[name] = _Looks(in_hand)
            looks.add(place - origin, sigma)
            x, y, z = (looks.mean + origin).tolist()
            positions[name] = (x, y, z)
            deviations[name] = max(looks.deviation, FLOOR * sigma)
        for name in [name for name in self._looks if name not in seen.positions]:
            del self._looks[name]
        return replace(seen, positions=positions, deviations=deviations)


class _Looks:
    """The looks at one object since it last moved, in the world or in the hand.

    A look is a row: its precision, and its place times that. Rows add up.
    """

    def __init__(self, in_hand: bool) -> None:
        self.in_hand = in_hand
        self._last = np.zeros((0, 4))
        self._before = np.zeros(4)

    def add(self, place: np.ndarray, sigma: float) -> None:
        """Take one more look; where the last few disagree with those before, only they count."""
        self._last = np.vstack([self._last, sigma**-2 * np.array([1.0, *place])])
        if len(self._last) > LAST[-1]:
            self._before += self._last[0]
            self._last = self._last[1:]
        recent = np.cumsum(self._last[::-1], axis=0)[[each - 1 for each in LAST if each <= len(self._last)]]
        earlier = self._sum - recent
        some = earlier[:, 0] > 0
        apart = _apart(recent[some], earlier[some])
        if apart.any():
            self._last = self._last[-LAST[int(apart.argmax())] :]
            self._before = np.zeros(4)

    @property
    def mean(self) -> np.ndarray:
        return np.asarray(self._sum[1:] / self._sum[0])

    @property
    def deviation(self) -> float:
        return float(self._sum[0] ** -0.5)

    @property
    def _sum(self) -> np.ndarray:
        return np.asarray(self._before + self._last.sum(axis=0))


def _apart(some: np.ndarray, others: np.ndarray) -> np.ndarray:
    """Return whether two sums of looks, each (K, 4), show different places, (K,)."""
    between = np.abs(some[:, 1:] / some[:, :1] - others[:, 1:] / others[:, :1]).max(axis=1, initial=0.0)
    return np.asarray(between > GATE * np.sqrt(1 / some[:, 0] + 1 / others[:, 0]))
