"""Grids of cells on which objects start: the paper's authors', and those of a crowd."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from ntp_dsl.semantics.free_space import Footprint, Region, clearance

JITTER, SPACING = 0.03, 0.08  # the authors' jitter and boundary boxes [m]
COLUMNS = (-0.15, -0.05, 0.05, 0.15)  # of the authors' grid, from its centre [m]
REDRAWS = 20_000  # of all spots, until they are far enough apart
TIGHT = 0.007  # between objects of a crowd, at least [m]
MOST_CELLS = 4  # of a grid, for each object

Spot = tuple[float, float]


def spots_on_grid(count: int, centre: Spot, rng: np.random.Generator) -> list[Spot] | None:
    """Return spots as the authors draw them: each in its own cell, jittered, none nearer than the spacing."""
    cells = [(x, y) for x in COLUMNS for y in COLUMNS]
    if count > len(cells):
        return None
    for _ in range(REDRAWS):
        chosen = rng.permutation(len(cells))[:count]
        spots = [_jittered(cells[index], centre, rng) for index in chosen]
        if _spaced(spots):
            return spots
    return None


def _jittered(cell: Spot, centre: Spot, rng: np.random.Generator) -> Spot:
    dx, dy = rng.uniform(-JITTER, JITTER, 2)
    return centre[0] + cell[0] + float(dx), centre[1] + cell[1] + float(dy)


def _spaced(spots: list[Spot]) -> bool:
    points = np.array(spots)
    gaps = np.linalg.norm(points[:, None] - points[None], axis=-1)
    return bool((gaps[np.triu_indices(len(spots), 1)] >= SPACING).all())


def in_cells(free: Sequence[Spot], pitch: float, width: float, rng: np.random.Generator) -> Iterator[Spot]:
    """Yield the cells in a random order, each with a jitter that leaves a gap to its neighbours."""
    jitter = max(0.0, min(0.01, (pitch - width) / 2 - TIGHT))
    for cell in rng.permutation(len(free)):
        dx, dy = rng.uniform(-jitter, jitter, 2)
        yield free[cell][0] + float(dx), free[cell][1] + float(dy)


def free_cells(
    count: int, width: float, region: Region, in_place: Sequence[Footprint]
) -> tuple[list[Spot], float] | None:
    """Return the free cells of the widest grid with at least that many, and their pitch; None without one."""
    (x0, x1), (y0, y1) = region
    for wanted in range(count, MOST_CELLS * count + 1):
        columns, rows = _grid(wanted, x1 - x0, y1 - y0)
        pitch = min((x1 - x0) / columns, (y1 - y0) / rows)
        if pitch < width + TIGHT:
            return None
        middles = [
            (x0 + (column + 0.5) * (x1 - x0) / columns, y0 + (row + 0.5) * (y1 - y0) / rows)
            for column in range(columns)
            for row in range(rows)
        ]
        clear = clearance(middles, (pitch, pitch), in_place) >= 0
        free = [middle for middle, is_clear in zip(middles, clear, strict=True) if is_clear]
        if len(free) >= count:
            return free, pitch
    return None


def covered_area(region: Region, spot: Sequence[float], size: Sequence[float]) -> float:
    """Return the area of a region that an object's footprint covers [m2]."""
    sides = [
        min(region[axis][1], spot[axis] + size[axis] / 2) - max(region[axis][0], spot[axis] - size[axis] / 2)
        for axis in (0, 1)
    ]
    return max(0.0, sides[0]) * max(0.0, sides[1])


def _grid(count: int, length: float, width: float) -> tuple[int, int]:
    """Return columns and rows of at least that many cells, as square as the region allows."""
    columns = max(1, round((count * length / width) ** 0.5))
    return columns, -(-count // columns)
