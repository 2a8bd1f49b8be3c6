"""What is observed of a world: the truth, late, from a camera that is off, and with noise."""

from __future__ import annotations

from collections import deque
from dataclasses import replace

import numpy as np

from ntp_dsl.semantics.geometry import Vector, moved
from ntp_dsl.semantics.observation import TOO_WIDE, Observation
from ntp_dsl.worlds.protocol import Disturbances


class Looks:
    """The looks of one episode. All of a look is late, the hand included, as it is one message."""

    def __init__(self, seed: int, disturbances: Disturbances) -> None:
        self._sigma, self._latency = disturbances.noise, disturbances.latency
        self._generator = np.random.default_rng((seed, 1))
        self.offset = camera_offset(seed, disturbances.camera)
        self._seen: deque[tuple[float, Observation]] = deque()

    def note(self, truth: Observation, time: float) -> None:
        """Take in the truth at a time [s], for later looks."""
        if self._latency:
            self._seen.append((time, truth))
            while len(self._seen) > 1 and self._seen[1][0] <= time - self._latency:
                self._seen.popleft()

    def of(self, truth: Observation, time: float) -> Observation:
        """Return what is observed at a time [s], given the truth then."""
        if self._latency:
            self.note(truth, time)
            truth = self._seen[0][1]  # the latest that is old enough, or the first of all
        if any(self.offset):
            small = {obj.name for obj in truth.objects if obj.size[0] <= TOO_WIDE}
            truth = replace(
                truth,
                positions={
                    name: moved(position, self.offset) if name in small else position
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


def camera_offset(seed: int, length: float) -> Vector:
    """Return a camera's error of an episode: a vector of a length [m], in a direction by the seed."""
    if not length:
        return (0.0, 0.0, 0.0)
    direction = np.random.default_rng((seed, 3)).normal(size=3)
    x, y, z = (length * direction / np.linalg.norm(direction)).tolist()
    return (x, y, z)
