"""What is the case in a moment, for each pair that the grounding network is asked about."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from math import inf

import numpy as np

from ntp_dsl.core.perception import features
from ntp_dsl.core.perception.features import as_float32, bodies
from ntp_dsl.core.pretraining.scenes import closed_on, looked_at, moments, shaken
from ntp_dsl.language.diagnostics.diagnostics import NtpError
from ntp_dsl.semantics import predicates
from ntp_dsl.semantics.containers import lies_in
from ntp_dsl.semantics.free_space import FREE_GAP, clearance
from ntp_dsl.semantics.observation import TOO_WIDE, Observation

SHAKEN = 0.06  # of the moments
CLOSED_ON = 0.08


@dataclass(frozen=True)
class Rows:
    """Inputs of one network, and the right answers."""

    inputs: np.ndarray  # (rows, features)
    answers: np.ndarray  # (rows, facts) 0 or 1; NaN where it is not asked


Parts = tuple[Rows, Rows, Rows]  # pairs, grip, hover


def rows_of(truth: Observation, seen: Observation) -> Parts:
    """Return what the networks are asked about one moment.

    Args:
        truth: where everything is.
        seen: where it is taken to be.
    """
    b = bodies(seen)
    item, below = features.near_pairs(b)
    pairs = Rows(
        as_float32(features.pair_features(b, item, below)), _pair_answers(truth, b.names, item, below)
    )
    hands = np.tile(seen.gripper, (len(b), 1))
    grip = features.grip_features(b, hands) if truth.closed else np.zeros((0, features.GRIP_FEATURES))
    held = [[float(name == truth.held)] for name in b.names] if truth.closed else []
    carried = np.full(len(b), b.names.index(truth.held) if truth.held else -1)
    hover = features.hover_features(b, hands, np.full(len(b), seen.closed), carried)
    return (
        pairs,
        Rows(as_float32(grip), np.array(held, dtype=np.float32).reshape(-1, 1)),
        Rows(as_float32(hover), _hover_answers(truth, b.names)),
    )


def _pair_answers(
    truth: Observation, names: tuple[str, ...], item: np.ndarray, below: np.ndarray
) -> np.ndarray:
    found = np.zeros((len(item), 3), dtype=np.float32)
    held = truth.held
    for row, (i, j) in enumerate(zip(item.tolist(), below.tolist(), strict=True)):
        a, c = names[i], names[j]
        if a == held:
            found[row] = np.nan  # the hand says that it neither stands nor lies
            found[row, 2] = lies_in(
                truth.by_name[a], truth.positions[a], truth.by_name[c], truth.positions[c]
            )
            continue
        found[row] = (
            predicates.rests_on(truth, a, c),
            predicates.covers(truth, a, c),
            predicates.inside(truth, a, c),
        )
    return found


def _hover_answers(truth: Observation, names: tuple[str, ...]) -> np.ndarray:
    """Return, for each object, whether the hand is over it, and whether it would be in the way there."""
    held = truth.held
    point = truth.positions[held] if held else truth.gripper
    size = truth.by_name[held].size if held else (0.0, 0.0, 0.0)
    found = np.full((len(names), 2), np.nan, dtype=np.float32)
    for row, name in enumerate(names):
        if name == held:
            continue
        obj, at = truth.by_name[name], truth.positions[name]
        if obj.flat:
            over = max(abs(point[k] - at[k]) - obj.size[k] / 2 for k in (0, 1)) < 0
        else:
            over = predicates.above(truth, "", name)
        gap = float(clearance(point[:2], size, [(at, obj.size)])) if obj.size[0] <= TOO_WIDE else inf
        found[row] = over, gap <= FREE_GAP
    return found


def of_scene(number: int, seed: int) -> list[Parts]:
    """Return the rows of one random scene; the same for the same seed."""
    rng = np.random.default_rng((seed, number))
    found = []
    for truth in moments(rng):
        moment = shaken(truth, rng) if rng.random() < SHAKEN else truth
        moment = closed_on(moment, rng) if rng.random() < CLOSED_ON else moment
        found.append(rows_of(moment, looked_at(moment, rng)))
    return found


def joined(found: Iterable[Parts]) -> Parts:
    """Return the rows of many moments as one. Raises `NtpError` where there are none."""
    found = list(found)
    if not found:
        raise NtpError("none of the made-up scenes had room: make more with --scenes")
    pairs, grip, hover = (
        Rows(
            np.concatenate([rows.inputs for rows in each]),
            np.concatenate([rows.answers for rows in each]),
        )
        for each in zip(*found, strict=True)
    )
    return pairs, grip, hover
