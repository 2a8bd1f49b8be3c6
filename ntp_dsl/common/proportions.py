"""Proportions and their intervals."""

from __future__ import annotations

from math import sqrt
from statistics import NormalDist

SIDES = NormalDist().inv_cdf(0.975)  # of a 95 % interval


def wilson(wins: int, count: int) -> tuple[float, float]:
    """Return the 95 % interval of a proportion (Wilson, 1927)."""
    share, spread = wins / count, SIDES**2 / count
    middle = share + spread / 2
    reach = SIDES * sqrt(share * (1 - share) / count + spread / (4 * count))
    low, high = ((middle + side) / (1 + spread) for side in (-reach, reach))
    return round(max(low, 0.0), 4), round(min(high, 1.0), 4)
