"""Free space on surfaces and in containers: clearances seen from above, and places for one more object."""

from __future__ import annotations

from collections.abc import Container, Iterable, Iterator, Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ntp_dsl.semantics.containers import contents
from ntp_dsl.semantics.geometry import Vector
from ntp_dsl.semantics.observation import TOO_WIDE, Observation, SceneObject

FREE_GAP = 0.015  # around an object, for the surface below it to count as free [m]
SPARE = 0.002  # beyond that gap, since the arm is not exact [m]
PITCH = 0.02  # of the candidate places [m]
AMPLE = 0.06  # more room than this to all others is no better [m]

Interval = tuple[float, float]
Region = tuple[Interval, Interval]  # of x and of y, world frame [m]
Footprint = tuple[Sequence[float], Sequence[float]]  # an object's centre and extents along x and y, ... [m]
Places = NDArray[np.float64]  # (N, 2), world frame [m]


def footprints(
    observation: Observation, except_for: Container[str | None]
) -> Iterator[tuple[Vector, Vector]]:
    """Yield the centre and size of each object on the table: all but the widest furniture."""
    for obj in observation.by_name.values():
        if obj.name not in except_for and obj.size[0] <= TOO_WIDE:
            if obj.name in observation.positions:
                yield observation.positions[obj.name], obj.size


def clearance(places: ArrayLike, size: Sequence[float], others: Iterable[Footprint]) -> NDArray[np.float64]:
    """Return how far an object at each place is from the nearest other, seen from above [m].

    The gap between two objects is the larger of their gaps along x and y; it is negative where they overlap.

    Args:
        places: (..., 2), of the object's centre; the result is (...,), infinite where there are no others.
    """
    at = np.asarray(places, dtype=float)
    table = np.array([(*centre[:2], *extent[:2]) for centre, extent in others]).reshape(-1, 4)
    gaps = np.abs(at[..., None, :] - table[:, :2]) - (table[:, 2:] + size[:2]) / 2  # (..., others, 2)
    return np.asarray(gaps.max(axis=-1).min(axis=-1, initial=np.inf))


def region_within(surface: SceneObject, at: Sequence[float], size: Sequence[float]) -> Region:
    """Return where the centre of an object may be, so that all of it is on a surface or in a hollow."""
    inner = surface.cavity or (surface.size[0] / 2, surface.size[1] / 2)
    dx, dy = (max(0.0, inner[axis] - size[axis] / 2) for axis in (0, 1))
    return (at[0] - dx, at[0] + dx), (at[1] - dy, at[1] + dy)


def rank_places(
    region: Region, size: Sequence[float], others: Sequence[Footprint], dense: bool = False
) -> tuple[Places, NDArray[np.float64]]:
    """Return the places of a region for an object, best first, and the clearance of each (N,) [m].

    The clearest come first; of equals the nearest to the region's middle.

    Args:
        dense: those that leave most room for more objects of the same size come first instead.
    """
    lattice = _lattice(region)
    room = np.minimum(clearance(lattice, size, others), AMPLE)
    value = _left_free(lattice, _is_free(room), size) if dense else room
    from_middle = np.linalg.norm(lattice - lattice.mean(axis=0), axis=1)
    order = np.lexsort((from_middle.round(6), -value.round(3)))
    return lattice[order], room[order]


def free_places(seen: Observation, surface: str, table: Sequence[Region]) -> list[tuple[float, float]]:
    """Return the places of a table or tray with room around them for the held object, best first.

    Args:
        table: where an object may be put on a table; each region is tried where the one before it is full.
    """
    below, held = seen.by_name[surface], seen.held
    size = seen.by_name[held].size if held else (0.0, 0.0, 0.0)
    others = list(footprints(seen, {held, surface, *load(seen, held)}))
    on_table = below.size[0] > TOO_WIDE
    for region in table if on_table else [region_within(below, seen.positions[surface], size)]:
        places, room = rank_places(region, size, others, dense=not on_table)
        free = places[_is_free(room)]
        if len(free):
            return [(x, y) for x, y in free.tolist()]
    return []


def place_in(seen: Observation, container: str, item: SceneObject) -> tuple[float, float]:
    """Return where to release an item over a container: farthest from its contents."""
    by_name = seen.by_name
    others = [(seen.positions[name], by_name[name].size) for name in load(seen, container)]
    region = region_within(by_name[container], seen.positions[container], item.size)
    x, y = rank_places(region, item.size, others)[0][0].tolist()
    return x, y


def load(observation: Observation, container: str | None) -> list[str]:
    """Return the contents of a container, which move with it."""
    objects = observation.by_name
    return contents(objects[container], objects.values(), observation.positions) if container else []


def height_below(seen: Observation, x: float, y: float) -> float:
    """Return the highest top below a point, or below the held object if that is over the point [m]."""
    held = seen.held
    size = seen.by_name[held].size if held else (0.0, 0.0, 0.0)
    tops = [
        place[2] + extent[2] / 2
        for place, extent in footprints(seen, {held, *load(seen, held)})
        if clearance((x, y), size, [(place, extent)]) < 0
    ]
    return max(tops, default=0.0)


def _lattice(region: Region) -> Places:
    axes = []
    for low, high in region:
        count = 1 + round((high - low) / PITCH)
        axes.append(np.linspace(low, high, count) if count > 1 else np.array([(low + high) / 2]))
    return np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 2)


def _is_free(room: NDArray[np.float64]) -> NDArray[np.bool_]:
    return np.asarray(room > FREE_GAP + SPARE)


def _left_free(lattice: Places, free: NDArray[np.bool_], size: Sequence[float]) -> NDArray[np.float64]:
    """(N,) how many of the free places stay so when an object of that size is put down at each."""
    apart = (np.abs(lattice[:, None] - lattice[None, free]) - size[:2]).max(axis=-1)  # (N, free)
    return np.asarray(_is_free(apart).sum(axis=1), dtype=float)
