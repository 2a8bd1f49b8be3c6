"""Which frames of a demonstration are read: enough to follow the hand, however fast it moved.

A recording has a frame every tenth of a second, most of them on a straight line between two others. The
kept ones are at most `SPACING` apart along the hand's path, and at its corners and where the hand opens or
closes. So a reading does not depend on the speed of the arm, nor on how long it stood still.
"""

from __future__ import annotations

from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from ntp_dsl.demonstrations.demonstration import Demonstration, Scope

SPACING = 0.06  # [m] along the hand's path
STEP = 0.008  # [m] a corner is looked for between steps of at least this
CORNER = 0.5  # cosine of the angle from which a change of direction is one


_KEPT: WeakKeyDictionary[Demonstration, NDArray[np.int64]] = WeakKeyDictionary()


def within(demonstration: Demonstration, scope: Scope) -> NDArray[np.int64]:
    """Numbers of the kept frames of a scope; its last frame is always among them."""
    begin, end = scope
    kept = _kept(demonstration)
    inside = kept[(kept >= begin) & (kept < end - 1)]
    return np.append(inside, end - 1)


def _kept(demonstration: Demonstration) -> NDArray[np.int64]:
    """Select the frames, once for a demonstration."""
    if demonstration not in _KEPT:
        _KEPT[demonstration] = keyframes(demonstration.relative, demonstration.closed)
    return _KEPT[demonstration]


def last_before(shown: NDArray[np.int64], frame: int) -> int:
    """Return the place of the last kept frame before a frame; the first one where there is none."""
    return max(int(np.searchsorted(shown, frame)) - 1, 0)


def keyframes(positions: NDArray[np.float32], closed: NDArray[np.bool_]) -> NDArray[np.int64]:
    """Numbers of the kept frames. positions: (frames, things, 3) relative to the hand."""
    # Most things stand still, so the hand's own path is the median of their apparent motion.
    steps = -np.median(np.diff(positions, axis=0), axis=1)
    path = np.concatenate([np.zeros((1, 3)), np.cumsum(steps, axis=0)])
    kept = [0]
    for frame in range(1, len(path)):
        since = path[frame] - path[kept[-1]]
        if closed[frame] != closed[kept[-1]] or _long(since) >= SPACING:
            kept.append(frame)
        elif _long(since) >= STEP and _turns(path, frame, since):
            kept.append(frame)
    return np.array(kept)


def _turns(path: NDArray[np.float64], frame: int, since: NDArray[np.float64]) -> bool:
    for later in path[frame + 1 :]:
        onward = later - path[frame]
        if _long(onward) >= STEP:
            return float(since @ onward) < CORNER * _long(since) * _long(onward)
    return False


def _long(vector: NDArray[np.float64]) -> float:
    return float(np.sqrt(vector @ vector))
