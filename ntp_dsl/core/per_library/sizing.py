"""How many things each frame of a demonstration points at: what a call takes, and what goes along with it."""

from __future__ import annotations

from collections.abc import Collection

import numpy as np
from numpy.typing import NDArray

from ntp_dsl.core.per_library.config import CoreConfig
from ntp_dsl.core.per_library.memory import Memory
from ntp_dsl.demonstrations.demonstration import Demonstration

LOADED = 0.1  # of the demonstrations, from which something is taken to go along with what is held
WAY = 0.008  # of the hand between two frames, from which what goes along shows [m]
ALONG = 0.002  # by which that moves in the hand, at most [m]


def sized(memory: Memory, demonstrations: Collection[Demonstration]) -> CoreConfig:
    """Return a core for a library and what is shown of it.

    A bowl and what is in it are in one place. Where such loads are carried, a pointer more leaves one for
    where they go.
    """
    plain = CoreConfig()
    loaded = np.mean([carries_a_load(each.relative, each.closed) for each in demonstrations])
    return CoreConfig(hops=plain.pointers(memory.arity) + int(loaded > LOADED))


def carries_a_load(positions: NDArray[np.float32], closed: NDArray[np.bool_]) -> bool:
    """Whether anything goes along with what the hand holds. positions: (frames, things, 3) relative to it."""
    steps = np.diff(positions, axis=0)
    far = np.linalg.norm(steps, axis=-1)  # (frames, things)
    way = far.max(axis=1)  # something stays behind, the table at least
    along = (far < ALONG).sum(axis=1)
    return bool((closed[1:] & closed[:-1] & (way > WAY) & (along > 1)).any())
