"""From the truth of a world to what is observed: late, by a camera that is off, and with noise."""

from __future__ import annotations

from collections import deque
from dataclasses import replace

import numpy as np

from ntp_dsl.semantics.geometry import Vector, moved
from ntp_dsl.semantics.observation import TOO_WIDE, Observation
from ntp_dsl.worlds.protocol import Disturbances

_ROUNDING = 1e-6  # of sums of time steps [s]


class Observer:
    """The observations of one episode. All of one is late, the hand included, as it is one message.

    Worlds wait after each call until what came of it is observed, as whoever reads time stamps would.
    """

    def __init__(self, seed: int, disturbances: Disturbances) -> None:
        self._sigma, self._latency = disturbances.noise, disturbances.latency
        self._generator = np.random.default_rng((seed, 1))
        self.camera_offset = offset_of(seed, disturbances.camera_offset)
        self._noted: deque[tuple[float, Observation]] = deque()

    def note(self, truth: Observation, time: float) -> None:
        """Take in the truth at a time [s], for later observations."""
        if self._latency:
            self._noted.append((time, truth))
            while len(self._noted) > 1 and self._noted[1][0] <= time - self._latency + _ROUNDING:
                self._noted.popleft()

    def observe(self, truth: Observation, time: float) -> Observation:
        """Return what is observed at a time [s], given the truth then: of what was noted, if that is late."""
        if self._latency:
            self.note(truth, time)
            truth = self._noted[0][1]  # the latest that is old enough, or the first of all
        if any(self.camera_offset):
            small = {obj.name for obj in truth.objects if obj.size[0] <= TOO_WIDE}
            truth = replace(
                truth,
                positions={
                    name: moved(position, self.camera_offset) if name in small else position
                    for name, position in truth.positions.items()
                },
            )
        if not self._sigma:
            return truth
        noisy = {
            name: moved(position, self._generator.normal(0, self._sigma, 3))
            for name, position in truth.positions.items()
        }
        return replace(truth, positions=noisy, deviations=dict.fromkeys(noisy, self._sigma))


def offset_of(seed: int, length: float) -> Vector:
    """Return the error of an episode's camera: a vector of a length [m], in a direction by the seed."""
    if not length:
        return (0.0, 0.0, 0.0)
    direction = np.random.default_rng((seed, 3)).normal(size=3)
    x, y, z = (length * direction / np.linalg.norm(direction)).tolist()
    return (x, y, z)
