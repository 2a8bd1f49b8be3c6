"""How often a run's trace is looked at while it is written, so that whoever looks costs the run little."""

from __future__ import annotations

LEAST = 0.3  # [s] between two looks
SHARE = 5  # times that a look took, between two of them


def pause(cost: float) -> float:
    """Return how long to wait after a look that took so long [s]."""
    return max(LEAST, SHARE * cost)
