"""Proportions and their intervals."""

from __future__ import annotations

from math import sqrt
from statistics import NormalDist

Z_95 = NormalDist().inv_cdf(0.975)  # of a 95 % interval


def wilson(wins: int, count: int) -> tuple[float, float]:
    """Return the 95 % interval of a proportion (Wilson, 1927)."""
    share, excess = wins / count, Z_95**2 / count
    middle = share + excess / 2
    half_width = Z_95 * sqrt(share * (1 - share) / count + excess / (4 * count))
    low, high = ((middle + side) / (1 + excess) for side in (-half_width, half_width))
    return round(max(low, 0.0), 4), round(min(high, 1.0), 4)
