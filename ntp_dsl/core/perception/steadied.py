"""States first: objects at rest are averaged over frames, and held ones are fixed in the hand."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from ntp_dsl.demonstrations.demonstration import Demonstration, Facts, Scope
from ntp_dsl.semantics.attempts import without_attempts
from ntp_dsl.semantics.observation import Observation

FLICKER = 0.2  # of the hand: opened or closed for a shorter time than that does not count [s]
REGRASP = 3.0  # a hand that opens in place for less than that, to grasp better, goes on holding [s]
STAYS = 0.02  # of such a hand from where it opened [m]
MOVED = 0.015  # of a trajectory's spread, above which an object does not rest [m]
RIGID = 0.6  # of the spread in the world, below which that in the hand makes an object a held one
FALL = 0.02  # of the spread, above which an object has moved within a phase without the hand [m]
SAME_PLACE = 0.002  # of the means of two phases, within which an object has not moved, without noise [m]
SPLITS = 3  # of a phase, at most

Points = NDArray[np.float64]
Rest = tuple[int, int, Points, Points]  # first frame, end, the looks between them, and their median


@dataclass(frozen=True, eq=False)
class Steadied:
    """A demonstration's states. A phase lies between two moments at which the hand opens or closes, or at
    which a fact of the state changes.
    """

    demonstration: Demonstration
    closed: NDArray[np.bool_]  # (T,) without flicker and regrasps
    positions: Points  # (T, N, 3): centres, world frame [m]
    deviations: NDArray[np.float64]  # (T, N): standard, of these [m]

    @cached_property
    def events(self) -> tuple[int, ...]:
        """Return the first frames after the hand has opened or closed, or a fact of the state has changed."""
        facts = self.demonstration.facts or ()
        changes = {
            k
            for k, (a, b) in enumerate(pairwise(facts), start=1)
            if a != b and without_attempts(a) != without_attempts(b)
        }
        return tuple(sorted(changes.union((np.flatnonzero(np.diff(self.closed.astype(int))) + 1).tolist())))

    def phases(self, scope: Scope) -> list[Scope]:
        """Return the phases of a part of the demonstration."""
        begin, end = scope
        inner = [frame for frame in self.events if begin < frame < end]
        return list(zip([begin, *inner], [*inner, end], strict=True))

    def changed(self, frame: int) -> Facts:
        """Return the facts of the state in which a frame differs from the one before it."""
        facts = self.demonstration.facts
        if facts is None:
            return frozenset()
        return without_attempts(facts[frame - 1]) ^ without_attempts(facts[frame])

    def observation(self, frame: int) -> Observation:
        """Return the state at a frame."""
        shown = self.demonstration
        turns = shown.orientations
        facts: Facts = shown.facts[frame] if shown.facts is not None else frozenset()
        return Observation(
            shown.objects,
            dict(zip(shown.names, map(tuple, self.positions[frame].tolist()), strict=True)),
            tuple(shown.grippers[frame].tolist()),
            bool(self.closed[frame]),
            orientations={}
            if turns is None
            else dict(zip(shown.names, map(tuple, turns[frame].tolist()), strict=True)),
            deviations={
                name: deviation
                for name, deviation in zip(shown.names, self.deviations[frame].tolist(), strict=True)
                if deviation
            },
            facts=facts,
        )


def steadied(demonstration: Demonstration) -> Steadied:
    """Return the states that a demonstration's frames are looks at."""
    closed = _deliberate(demonstration)
    positions = demonstration.positions.copy()
    deviations = np.zeros(positions.shape[:2])
    raw = Steadied(demonstration, closed, positions, deviations)
    noise = _noise(demonstration, raw)
    resting: list[list[Rest]] = [[] for _ in demonstration.objects]
    for begin, end in raw.phases((0, len(demonstration))):
        shown = demonstration.positions[begin:end]
        hand = demonstration.grippers[begin:end, None]
        still = _spread(shown)
        carried = _spread(shown - hand) if closed[begin] else still
        middles = np.median(shown, axis=0)
        for index, obj in enumerate(demonstration.objects):
            if not obj.movable:
                resting[index].append((begin, end, shown[:, index], middles[index]))
            elif closed[begin] and still[index] > MOVED and carried[index] < RIGID * still[index]:
                offset, deviation = _mean((shown - hand)[:, index], noise[index])
                positions[begin:end, index] = hand[:, 0] + offset
                deviations[begin:end, index] = deviation
            else:
                most = max(FALL, 6 * noise[index])
                if still[index] < most:
                    resting[index].append((begin, end, shown[:, index], middles[index]))
                    continue
                for a, b in _pieces(shown[:, index], most):
                    part = shown[a:b, index]
                    resting[index].append((begin + a, begin + b, part, np.median(part, axis=0)))
    for index, pieces in enumerate(resting):
        for begin, end, frames, _ in _joined(pieces, noise[index]):
            place, deviation = _mean(frames, noise[index])
            positions[begin:end, index] = place
            deviations[begin:end, index] = deviation
    return Steadied(demonstration, closed, positions, deviations)


def _deliberate(demonstration: Demonstration) -> NDArray[np.bool_]:
    """Return whether the hand is closed, (T,), without flicker, and without opening to grasp better."""
    closed = demonstration.closed.copy()
    times = demonstration.times
    for begin, end in _runs(closed)[1:-1]:
        if times[end] - times[begin] < FLICKER - 1e-6:
            closed[begin:end] = closed[begin - 1]
    until = len(closed)  # the end of the run after the one that is looked at
    for begin, end in reversed(_runs(closed)[1:-1]):
        is_brief = not closed[begin] and times[end] - times[begin] < REGRASP
        if is_brief and _regrasps(demonstration, begin, end, until):
            closed[begin:end] = True
        else:
            until = end
    return closed


def _runs(closed: NDArray[np.bool_]) -> list[Scope]:
    """Return the first frames and the ends between which the hand neither opens nor closes."""
    begins = [0, *(np.flatnonzero(np.diff(closed.astype(int))) + 1).tolist()]
    return list(zip(begins, [*begins[1:], len(closed)], strict=True))


def _regrasps(demonstration: Demonstration, begin: int, end: int, until: int) -> bool:
    """Return whether a hand that is open from `begin` to `end` stays, and then moves what it had held."""
    hand = demonstration.grippers[begin - 1 : end + 1]
    if np.linalg.norm(hand - hand[0], axis=1).max() >= STAYS:
        return False
    movable = [index for index, each in enumerate(demonstration.objects) if each.movable]
    if not movable:
        return False
    places = demonstration.positions[:, movable]
    held = int(np.linalg.norm(places[begin - 1] - hand[0], axis=1).argmin())
    moved = np.linalg.norm(places[end:until, held] - places[end, held], axis=1)
    return bool(moved.max(initial=0.0) > STAYS)


def _noise(demonstration: Demonstration, raw: Steadied) -> NDArray[np.float64]:
    """Return the standard deviation of the looks at each object, (N,) [m].

    It is as stated, or else the same for all, as objects at rest show it.
    """
    count = len(demonstration.objects)
    if demonstration.deviations is not None:
        return np.median(demonstration.deviations, axis=0).astype(float)
    found = [
        np.diff(demonstration.positions[begin:end], axis=0).std(axis=(0, 2)) / np.sqrt(2)
        for begin, end in raw.phases((0, len(demonstration)))
        if end - begin > 5
    ]
    return np.full(count, np.median(np.concatenate(found)) if found else 0.0)


def _spread(points: Points) -> NDArray[np.float64]:
    """Return how far objects are spread along the axis where that is most, (N,) [m]."""
    low, high = np.percentile(points, (5, 95), axis=0)
    return np.asarray((high - low).max(axis=-1))


def _mean(points: Points, noise: float) -> tuple[Points, float]:
    """Return the mean of a point's looks, without stray ones, and its standard deviation [m]."""
    middle = np.median(points, axis=0)
    near = np.abs(points - middle).max(axis=1) <= max(3 * noise, 1e-3)
    kept = points[near] if near.any() else points[-1:]
    return kept.mean(axis=0), noise / np.sqrt(len(kept))


def _pieces(points: Points, most: float, splits: int = SPLITS) -> list[Scope]:
    """Return the intervals in which an object rests: it may fall between two of them."""
    count = len(points)
    if splits == 0 or count < 3 or float(_spread(points[:, None])[0]) < most:
        return [(0, count)]
    total, squares = np.cumsum(points, axis=0), np.cumsum(points**2, axis=0)
    sizes = np.arange(1, count)[:, None]
    left = squares[:-1] - total[:-1] ** 2 / sizes
    right = (squares[-1] - squares[:-1]) - (total[-1] - total[:-1]) ** 2 / (count - sizes)
    at = int((left + right).sum(axis=1).argmin()) + 1
    after = [(at + a, at + b) for a, b in _pieces(points[at:], most, splits - 1)]
    return [*_pieces(points[:at], most, splits - 1), *after]


def _joined(pieces: list[Rest], noise: float) -> Iterator[Rest]:
    """Yield intervals of rest, those put together between which an object has not moved."""
    waiting: list[Rest] = []
    for piece in pieces:
        if waiting and not (waiting[-1][1] == piece[0] and _same_place(waiting[-1], piece, noise)):
            yield _whole(waiting)
            waiting = []
        waiting.append(piece)
    if waiting:
        yield _whole(waiting)


def _whole(pieces: list[Rest]) -> Rest:
    return pieces[0][0], pieces[-1][1], np.concatenate([frames for _, _, frames, _ in pieces]), pieces[-1][3]


def _same_place(some: Rest, other: Rest, noise: float) -> bool:
    apart = np.abs(some[3] - other[3]).max()
    doubt = 5 * noise * np.sqrt(1 / len(some[2]) + 1 / len(other[2]))
    return bool(apart < SAME_PLACE + doubt)
