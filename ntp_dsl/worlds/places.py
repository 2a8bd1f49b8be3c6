"""Where on a table or tray there is room for what the hand holds, as the predicate `above` sees it."""

from __future__ import annotations

import numpy as np

from ntp_dsl.semantics.geometry import Vector
from ntp_dsl.semantics.observation import TOO_WIDE, Observation, SceneObject
from ntp_dsl.semantics.predicates import FREE_GAP, footprints, load
from ntp_dsl.worlds.starts import REGION, WIDE

PITCH = 0.02  # of the places that are looked at [m]
AMPLE = 0.06  # more room than this to all others is no better [m]
SPARE = 0.002  # beyond what the predicate asks for, since the arm is not exact [m]


def free_places(seen: Observation, surface: str) -> tuple[list[tuple[float, float]], float]:
    """Places of a surface with room around them, and its height [m].

    On a table the clearest come first; on a tray, those that leave most room for more of the same size.
    Of equals the nearest to its middle.
    """
    below = seen.by_name[surface]
    held = seen.held
    size = seen.by_name[held].size if held else (0.0, 0.0, 0.0)
    lattice = _lattice(seen, below, size)  # (N, 2)
    others = list(footprints(seen, {held, surface, *load(seen, held)}))
    room = np.full(len(lattice), AMPLE)
    for (x, y, _), extent in others:
        apart = np.abs(lattice - (x, y)) - (np.array(extent[:2]) + size[:2]) / 2
        room = np.minimum(room, apart.max(axis=1))
    from_middle = np.linalg.norm(lattice - lattice.mean(axis=0), axis=1)
    top = seen.positions[surface][2] + below.size[2] / 2
    free = room > FREE_GAP + SPARE
    welcome = room if below.size[0] > TOO_WIDE else _left_free(lattice, free, np.array(size[:2]))
    order = np.lexsort((from_middle.round(6), -welcome.round(3)))
    chosen = [int(k) for k in order if free[k]]
    return [(float(lattice[k, 0]), float(lattice[k, 1])) for k in chosen], top


def _left_free(lattice: np.ndarray, free: np.ndarray, size: np.ndarray) -> np.ndarray:
    """(N,) how many of the free places stay so when an object of that size is put down at each."""
    apart = (np.abs(lattice[:, None] - lattice[None, free]) - size).max(axis=-1)  # (N, free)
    return np.asarray((apart > FREE_GAP + SPARE).sum(axis=1), dtype=float)


def height_below(seen: Observation, x: float, y: float) -> float:
    """The highest top of what lies below a point, or below what is held if that is over the point [m]."""
    held = seen.held
    size = seen.by_name[held].size if held else (0.0, 0.0, 0.0)
    tops = [
        place[2] + extent[2] / 2
        for place, extent in footprints(seen, {held, *load(seen, held)})
        if abs(place[0] - x) < (size[0] + extent[0]) / 2 and abs(place[1] - y) < (size[1] + extent[1]) / 2
    ]
    return max(tops, default=0.0)


def _lattice(seen: Observation, surface: SceneObject, size: Vector) -> np.ndarray:
    """(N, 2): where the middle of an object of that size may be put down [m]."""
    if surface.size[0] > TOO_WIDE:
        region = np.array(WIDE if any(obj.fixed for obj in seen.objects) else REGION)  # (axis, ends)
    else:
        middle = np.array(seen.positions[surface.name][:2])
        half = np.maximum(0.0, (np.array(surface.size[:2]) - size[:2]) / 2)
        region = np.stack([middle - half, middle + half], axis=1)
    axes = [np.linspace(low, high, 1 + round((high - low) / PITCH)) for low, high in region.tolist()]
    return np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 2)
