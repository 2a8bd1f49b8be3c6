"""What the grounding network is told of two objects, and of the hand and one: lengths at several scales.

A length is told as it is, and squashed at scales from millimetres to a decimetre and at that of its
doubt, so that a network of few weights can place a threshold anywhere. No type, name or trait is among them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ntp_dsl.semantics.observation import TOO_WIDE, Observation, SceneObject

SCALES = (0.003, 0.01, 0.03, 0.1)  # [m]
LEAST_DOUBT = 0.0005  # [m]
NEAR = 0.04  # of two objects seen from above, beyond which no fact of contact is asked [m]
SURELY = 4.0  # deviations
OVERLAP = 0.75  # of a height, by which one that leans on another may be lower, or higher

Array = NDArray[np.float64]

PAIR_LENGTHS, GRIP_LENGTHS, HOVER_LENGTHS = 14, 4, 14
TOLD_OF_ONE = 9  # of each object: size, reach, shape
PAIR_FEATURES = PAIR_LENGTHS * (len(SCALES) + 2) + 2 * TOLD_OF_ONE + 3
GRIP_FEATURES = GRIP_LENGTHS * (len(SCALES) + 2) + TOLD_OF_ONE + 3
HOVER_FEATURES = HOVER_LENGTHS * (len(SCALES) + 2) + 2 * TOLD_OF_ONE + 5


@dataclass(frozen=True)
class Bodies:
    """The objects of an observation that have a position, as arrays."""

    objects: tuple[SceneObject, ...]
    names: tuple[str, ...]
    at: Array  # (N, 3) centres [m]
    size: Array  # (N, 3) as they lie [m]
    deviation: Array  # (N,) [m]
    told: Array  # (N, TOLD_OF_ONE)
    cavity: Array  # (N, 2) half of a hollow's extent; -1 where there is none [m]
    floor: Array  # (N,) of the hollow, above the bottom [m]
    movable: NDArray[np.bool_]
    roomy: NDArray[np.bool_]
    flat: NDArray[np.bool_]
    wide: NDArray[np.bool_]  # a table: nothing to bump into

    def __len__(self) -> int:
        return len(self.names)


def bodies(seen: Observation) -> Bodies:
    """Return the objects of an observation."""
    objects = tuple([obj for obj in seen.objects if obj.name in seen.positions])
    still = _still(objects)
    at = np.array([seen.positions[name] for name in still.names]).reshape(-1, 3)
    deviation = np.array([seen.deviations.get(name, 0.0) for name in still.names])
    return replace(still, at=at, deviation=deviation)


@lru_cache(maxsize=16)
def _still(objects: tuple[SceneObject, ...]) -> Bodies:
    """Return objects without their positions, which `bodies` fills in; they are the same at every moment."""
    cavities = [obj.cavity for obj in objects]
    size = np.array([obj.size for obj in objects]).reshape(-1, 3)
    reach = np.array([obj.reach for obj in objects])
    flags = [
        (obj.movable, obj.roomy, cavity is not None, obj.shape in ("cylinder", "bowl"), obj.shape == "bowl")
        for obj, cavity in zip(objects, cavities, strict=True)
    ]
    told = np.concatenate(
        [10 * np.minimum(size, 0.3), 10 * np.minimum(reach, 0.3)[:, None], np.array(flags).reshape(-1, 5)], 1
    )
    return Bodies(
        objects,
        tuple(obj.name for obj in objects),
        np.zeros((len(objects), 3)),
        size,
        np.zeros(len(objects)),
        told,
        np.array([(c.half_x, c.half_y) if c else (-1.0, -1.0) for c in cavities]).reshape(-1, 2),
        np.array([c.floor if c else 0.0 for c in cavities]),
        np.array([obj.movable for obj in objects], dtype=bool),
        np.array([obj.roomy for obj in objects], dtype=bool),
        np.array([obj.flat for obj in objects], dtype=bool),
        np.array([obj.size[0] > TOO_WIDE for obj in objects], dtype=bool),
    )


def joined(scenes: Sequence[Bodies]) -> Bodies:
    """Return the objects of several scenes as those of one."""
    if len(scenes) == 1:
        return scenes[0]
    parts: dict[str, Any] = {
        each.name: np.concatenate([getattr(b, each.name) for b in scenes])
        for each in fields(Bodies)
        if each.name not in ("objects", "names")
    }
    objects = tuple(obj for b in scenes for obj in b.objects)
    return Bodies(objects, tuple(obj.name for obj in objects), **parts)


def near_pairs(b: Bodies) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Return the pairs, an object and what it may lie on or in, that may touch."""
    if not len(b):
        nothing = np.zeros(0, dtype=np.intp)
        return nothing, nothing
    x, y, wide, deep, tall = *b.at[:, :2].T, *b.size.T
    most = NEAR + SURELY * np.hypot(b.deviation.max(), b.deviation.max())
    beside = np.abs(x[:, None] - x) - (wide[:, None] + wide) / 2 < most  # most pairs are apart in one axis
    item, below = np.nonzero(beside & b.movable[:, None])
    doubt = NEAR + SURELY * np.hypot(b.deviation[item], b.deviation[below])
    gap = (b.at[item, 2] - tall[item] / 2) - (b.at[below, 2] + tall[below] / 2)  # from the one's top up
    lower = -OVERLAP * np.minimum(tall[item], tall[below]) - doubt
    level = (gap > lower) & (gap < OVERLAP * tall[item] + doubt) | (b.cavity[below, 0] > 0)
    near = np.abs(x[item] - x[below]) - (wide[item] + wide[below]) / 2 < doubt
    near &= np.abs(y[item] - y[below]) - (deep[item] + deep[below]) / 2 < doubt
    near &= level & (item != below)
    return item[near], below[near]


def pair_features(b: Bodies, item: NDArray[np.intp], below: NDArray[np.intp]) -> Array:
    """(pairs, PAIR_FEATURES): an object over, on, in or beside another."""
    dx, dy, dz = _apart(b, item, below)
    aside = np.hypot(dx, dy)
    half, under = b.size[item] / 2, b.size[below] / 2
    cavity = b.cavity[below]
    lengths = np.array(
        [
            dx,
            dy,
            aside,
            dz - half[:, 2] - under[:, 2],  # the gap from the one's top to the other's bottom
            dz + under[:, 2],  # of the centre, from the bottom of the one below
            dz - under[:, 2],  # and from its rim
            dx - 0.9 * (half[:, 0] + under[:, 0]),
            dy - 0.9 * (half[:, 1] + under[:, 1]),
            dx - under[:, 0],
            dy - under[:, 1],
            aside - under[:, 0],
            dx - cavity[:, 0],
            dy - cavity[:, 1],
            np.minimum(half[:, 2], under[:, 2]),
        ]
    ).T
    doubt = np.hypot(b.deviation[item], b.deviation[below])
    return np.concatenate([_told(lengths, doubt), b.told[item], b.told[below], _doubts(doubt)], axis=1)


def grip_features(b: Bodies, hands: Array) -> Array:
    """(objects, GRIP_FEATURES): an object between the fingers, or not.

    Args:
        hands: (objects, 3) the fingers' centre, in each object's scene [m].
    """
    way = b.at - hands
    aside, rise = np.hypot(way[:, 0], way[:, 1]), np.abs(way[:, 2])
    rim = np.abs(np.hypot(aside, way[:, 2]) - np.hypot(b.size[:, 0], b.size[:, 2]) / 2)
    lengths = np.array([aside, rise, rise - b.size[:, 2] / 2, rim]).T
    return np.concatenate([_told(lengths, b.deviation), b.told, _doubts(b.deviation)], axis=1)


def hover_features(b: Bodies, hands: Array, closed: NDArray[np.bool_], carried: NDArray[np.intp]) -> Array:
    """(objects, HOVER_FEATURES): what is carried, or else the hand, over an object, or beside it.

    Args:
        hands: (objects, 3) the fingers' centre, in each object's scene [m].
        closed: (objects,) whether the fingers are, there.
        carried: (objects,) the index of what is carried there; -1 for nothing.
    """
    carries = carried >= 0
    point = np.where(carries[:, None], b.at[carried], hands)
    size = np.where(carries[:, None], b.size[carried], 0.0)
    told = np.where(carries[:, None], b.told[carried], 0.0)
    doubt = np.where(carries, np.hypot(b.deviation, b.deviation[carried]), b.deviation)
    dx, dy = np.abs(b.at[:, :2] - point[:, :2]).T
    aside = np.hypot(dx, dy)
    half = b.size / 2
    rise = hands[:, 2] - b.at[:, 2] - half[:, 2]
    gap_x, gap_y = dx - half[:, 0] - size[:, 0] / 2, dy - half[:, 1] - size[:, 1] / 2
    lengths = np.array(
        [
            dx,
            dy,
            aside,
            rise,
            rise - 0.2,
            point[:, 2] - b.at[:, 2],
            np.abs(aside - half[:, 0]),
            dx - half[:, 0],
            dy - half[:, 1],
            dx - b.cavity[:, 0],
            dy - b.cavity[:, 1],
            gap_x,
            gap_y,
            np.maximum(gap_x, gap_y),
        ]
    ).T
    flags = np.array([carries, closed], dtype=float).T
    return np.concatenate([_told(lengths, doubt), b.told, told, _doubts(doubt), flags], axis=1)


def _apart(b: Bodies, item: NDArray[np.intp], below: NDArray[np.intp]) -> tuple[Array, Array, Array]:
    way = b.at[item] - b.at[below]
    return np.abs(way[:, 0]), np.abs(way[:, 1]), way[:, 2]


def _told(lengths: Array, doubt: Array) -> Array:
    """(rows, lengths × (scales + 2)): as they are, squashed at each scale, and at that of their doubt."""
    count, width = lengths.shape
    scales = np.empty((count, len(SCALES) + 1, 1))
    scales[:, :-1, 0], scales[:, -1, 0] = SCALES, 2 * doubt + LEAST_DOUBT
    squashed = np.tanh(lengths[:, None] / scales).reshape(count, (len(SCALES) + 1) * width)
    return np.concatenate([np.clip(5 * lengths, -2, 2), squashed], axis=1)


def _doubts(doubt: Array) -> Array:
    return np.array([50 * doubt, np.tanh(doubt / 0.003), np.tanh(doubt / 0.01)]).T


def as_float32(rows: Array) -> NDArray[Any]:
    return rows.astype(np.float32)
