"""Short demonstrations that are drawn by hand, to know what must be made of them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from ntp_dsl.demonstrations.demonstration import Demonstration
from ntp_dsl.semantics.geometry import Vector
from ntp_dsl.semantics.observation import Observation, SceneObject

RATE = 10.0  # frames a second
CUBE = 0.05  # [m]
AWAY = (0.4, 0.0, 0.45)


def cube(name: str, fixed: bool = False) -> SceneObject:
    return SceneObject(name, "Block", (CUBE, CUBE, CUBE), fixed=fixed)


def film(
    paths: Mapping[str, np.ndarray],
    closed: Sequence[bool] | np.ndarray,
    hand: np.ndarray | None = None,
    rate: float = RATE,
    noise: float = 0.0,
    stated: bool = False,
    seed: int = 0,
) -> Demonstration:
    """Return a demonstration of cubes along paths, (T, 3) each.

    Args:
        noise: standard, of the positions that are shown [m].
        stated: whether the demonstration says so.
    """
    count = len(closed)
    true = np.stack([np.broadcast_to(path, (count, 3)) for path in paths.values()], axis=1)
    seen = true + np.random.default_rng(seed).normal(0, noise, true.shape)
    return Demonstration(
        tuple(map(cube, paths)),
        (np.arange(count) / rate).astype(np.float32),
        np.array(closed, dtype=bool),
        np.broadcast_to(np.array(AWAY) if hand is None else hand, (count, 3)).copy(),
        seen,
        deviations=np.full(seen.shape[:2], noise, dtype=np.float32) if stated else None,
    )


def look(
    positions: Mapping[str, Vector],
    sigma: float | Mapping[str, float] = 0.0,
    gripper: Vector = AWAY,
    closed: bool = False,
) -> Observation:
    """Return an observation of cubes."""
    each = sigma if isinstance(sigma, Mapping) else dict.fromkeys(positions, sigma)
    deviations = {name: value for name, value in each.items() if value}
    return Observation(tuple(map(cube, positions)), positions, gripper, closed, deviations=deviations)


def as_vector(place: np.ndarray) -> Vector:
    x, y, z = place.tolist()
    return x, y, z
