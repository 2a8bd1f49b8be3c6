"""The grounding network (f_ENC): probabilities of the worlds' own facts, from an observation."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
import torch
from numpy.typing import NDArray
from torch import nn

from ntp_dsl.core.mlp import Mlp
from ntp_dsl.core.perception import features
from ntp_dsl.core.perception.features import Array, Bodies, bodies, joined
from ntp_dsl.semantics.graded import NO_CONTACT, Graded
from ntp_dsl.semantics.observation import Observation
from ntp_dsl.semantics.predicates import FLOOR_BELOW

WIDTH = 64

Pairs = tuple[NDArray[np.intp], NDArray[np.intp]]


class Grounding(nn.Module):
    """Three small networks: of two objects, of the fingers and one, of what is carried and one."""

    def __init__(self, width: int = WIDTH) -> None:
        super().__init__()
        self.pairs = Mlp(features.PAIR_FEATURES, width, width, 3)  # on, covers, in
        self.grip = Mlp(features.GRIP_FEATURES, width, width, 1)  # holding
        self.hover = Mlp(features.HOVER_FEATURES, width, width, 2)  # over, crowding


def ground(network: Grounding, seen: Observation) -> Graded:
    """Return what is probably the case."""
    return ground_all(network, [seen])[0]


@torch.inference_mode()
def ground_all(network: Grounding, seen: Sequence[Observation]) -> list[Graded]:
    """Return what is probably the case in each of several moments; each network is run once for all."""
    scenes = [*map(bodies, seen)]
    counts = [*map(len, scenes)]
    ends = np.cumsum(counts, dtype=np.intp)
    everything, first = joined(scenes), ends - np.array(counts, dtype=np.intp)
    hands = np.repeat([each.gripper for each in seen], counts, axis=0)
    closed = np.repeat([each.closed for each in seen], counts)
    grips = np.zeros(len(everything))
    if closed.any():  # an open hand holds nothing
        chances = _chances(network.grip, features.grip_features(everything, hands))[:, 0]
        grips = np.where(everything.movable & closed, chances, 0.0)
    held = np.split(grips, ends[:-1])
    carried = [int(each.argmax()) if len(each) and each.max() > 0.5 else None for each in held]
    indices = [-1 if index is None else start + index for index, start in zip(carried, first, strict=True)]
    near = [features.near_pairs(b) for b in scenes]
    touching = _contacts(network.pairs, scenes, near, everything, first)
    rows = features.hover_features(everything, hands, closed, np.repeat(indices, counts))
    hovering = np.split(_chances(network.hover, rows), ends[:-1])
    return [_graded(*each) for each in zip(scenes, held, carried, near, touching, hovering, strict=True)]


def _graded(
    b: Bodies, held: Array, carried: int | None, near: Pairs, touching: Array, hovering: Array
) -> Graded:
    holding = dict.fromkeys(b.names, 0.0)
    free = np.ones(len(b))
    if len(held):
        best = int(held.argmax())
        holding[b.names[best]] = float(held[best])  # a hand holds one thing
        free[best] -= held[best]
    item, below = near
    touching = np.minimum(touching, free[item, None])
    touching[:, 0] = np.minimum(touching[:, 0], 1 - _elsewhere(b, item, below, touching))
    covered = np.zeros(len(b))
    np.maximum.at(covered, below, touching[:, 1])
    names = np.array(b.names, dtype=object)
    pairs = zip(names[item].tolist(), names[below].tolist(), strict=True)
    contacts = dict(zip(pairs, map(tuple, touching.tolist()), strict=True))
    hovered = _hovered(b, carried, contacts, hovering)
    by_name = dict(zip(b.names, covered.tolist(), strict=True))
    return Graded(contacts, holding, hovered, by_name, max(holding.values(), default=0.0))


def _elsewhere(b: Bodies, item: NDArray[np.intp], below: NDArray[np.intp], touching: Array) -> Array:
    """Return how probably each item of a pair rests on, or lies in, something that is above the other.

    Of pairs whose other is no roomy surface, that is not asked.
    """
    found = np.zeros(len(item))
    top, roomy = b.at[:, 2] + b.size[:, 2] / 2, b.roomy[below]
    floor = (b.at[:, 2] - b.size[:, 2] / 2 + b.floor)[below]
    covers = np.where(roomy, 0.0, touching[:, 1])
    by_height: dict[float, Array] = {}  # surfaces of one height have the same above them
    for surface in np.flatnonzero(b.roomy).tolist():
        height = float(top[surface])
        if height not in by_height:
            lies = np.where(floor > height - FLOOR_BELOW, touching[:, 2], 0.0)  # else the surface is in it
            rests = np.where(roomy & (top[below] > height), touching[:, 0], 0.0)
            by_height[height] = np.maximum(np.maximum(covers, lies), rests)
        chances = by_height[height]
        most = np.zeros(len(b))
        np.maximum.at(most, item, np.where(below == surface, 0.0, chances))
        found = np.where(below == surface, most[item], found)
    return found


def _hovered(
    b: Bodies,
    carried: int | None,
    contacts: Mapping[tuple[str, str], tuple[float, float, float]],
    hovering: Array,
) -> dict[str, float]:
    """Return what the hand is over: over flat surfaces, only where nothing is in the way."""
    over, crowding = hovering[:, 0].copy(), np.where(b.wide, 0.0, hovering[:, 1])
    if carried is not None:
        over[carried] = crowding[carried] = 0.0
        for index, name in enumerate(b.names):  # what lies in it moves along
            crowding[index] *= 1 - contacts.get((name, b.names[carried]), NO_CONTACT)[2]
    highest = np.argsort(-crowding)[:2]
    for index in np.flatnonzero(b.flat).tolist():
        others = [crowding[each] for each in highest if each != index]
        over[index] = min(over[index], 1 - max(others, default=0.0))
    return dict(zip(b.names, over.tolist(), strict=True))


def _contacts(
    network: nn.Module,
    scenes: Sequence[Bodies],
    near: Sequence[Pairs],
    everything: Bodies,
    first: NDArray[np.intp],
) -> list[Array]:
    """Return the probabilities of contact in each scene: two objects that have not moved are asked once.

    Args:
        everything: the objects of all scenes.
        first: (scenes,) where those of each begin.
    """
    item, below = (
        np.concatenate([pairs[side] + start for pairs, start in zip(near, first, strict=True)])
        for side in (0, 1)
    )
    if len(scenes) == 1:  # no two objects come twice
        return [_chances(network, features.pair_features(everything, item, below))]
    places = zip(
        map(id, everything.objects),
        map(tuple, everything.at.tolist()),
        everything.deviation.tolist(),
        strict=True,
    )
    versions: dict[object, int] = {}
    version = np.array([versions.setdefault(each, len(versions)) for each in places], dtype=np.int64)
    keys = version[item] << 32 | version[below]
    _, asked, answers = np.unique(keys, return_index=True, return_inverse=True)
    rows = features.pair_features(everything, item[asked], below[asked])
    ends = np.cumsum([len(pairs[0]) for pairs in near])
    return np.split(_chances(network, rows)[answers], ends[:-1])


def _chances(network: nn.Module, rows: Array) -> Array:
    """Return the probabilities of each row."""
    told = torch.from_numpy(features.as_float32(rows))
    return torch.sigmoid(network(told)).numpy().astype(float)
