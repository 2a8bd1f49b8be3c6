"""The states of a demonstration that a reading looks at: a few before and after each act of the hand."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ntp_dsl.core.perception.steadied import Steadied
from ntp_dsl.core.reading.likelihood import Offset, Perceive, Places, places
from ntp_dsl.demonstrations.demonstration import Scope
from ntp_dsl.semantics.free_space import load
from ntp_dsl.semantics.observation import DeclaredFact
from ntp_dsl.semantics.state import State

ARRIVED = 0.012  # of the hand from where it will act, seen from above [m]
LOOKS = 5  # between its arrival and the act, at most
SETTLED = 2  # frames after the hand has come to rest that still belong to an act
RESTING = 0.002  # of the hand from where it is at the end [m]
SPAN = 0.1  # before and after a frame, and at least one frame each: there the hand's speed is measured [s]
STILL = 1e-3  # [m/s] speeds nearer than this are the same
LIFTED = 0.02  # of the hand's heights as it comes or goes, below which it counts as not lifted [m]


@dataclass(frozen=True)
class Act:
    """The hand closes or opens, or a fact changes: the frames that lead to it, and those after it."""

    number: int  # among those of its part of the demonstration
    frame: int  # the first after it
    start: int  # of the phase before it
    before: tuple[int, ...]  # when the hand is where it acts, in their order
    after: tuple[int, ...]
    left: int  # the first frame in which the hand is on its way, after the act before
    arrived: int  # the first in which it is there
    end: int  # the first in which it has left again
    changed: frozenset[DeclaredFact]  # the facts that it is the change of; none of an act of the hand


class Moments:
    """The states of a part of a demonstration."""

    def __init__(self, shown: Steadied, scope: Scope, perceive: Perceive) -> None:
        self.scope = scope
        self._shown, self._perceive = shown, perceive
        self._states: dict[int, State] = {}

    def state(self, frame: int) -> State:
        if frame not in self._states:
            needed = {frame, *self._needed} - self._states.keys()
            states = self._perceive([self._shown.observation(each) for each in sorted(needed)])
            self._states |= dict(zip(sorted(needed), states, strict=True))
        return self._states[frame]

    @property
    def _needed(self) -> Iterator[int]:
        """Yield the frames that a reading is likely to look at; they are perceived together."""
        for _, end in self.phases:
            yield end - 1
        for act in self.acts:
            yield from (act.start, *act.before[:1])

    def beside(self, frame: int, item: str) -> Places:
        """Return the states that a frame would show if an object lay a little beside where it does."""
        return places(self.state(frame), item, self._perceive)

    def moved(self, item: str, frame: int, by: Offset) -> Moments:
        """Return the states that would be shown if an object, and what lies in it, lay elsewhere.

        It lies there for as long as it rests as in a frame.
        """
        positions = self._shown.positions.copy()
        for name in (item, *load(self.state(frame).observation, item)):
            index = self._shown.demonstration.names.index(name)
            still = (positions[:, index] == positions[frame, index]).all(axis=1)
            others = np.flatnonzero(~still)
            begin = int(others[others < frame].max(initial=-1)) + 1
            end = int(others[others > frame].min(initial=len(positions)))
            positions[begin:end, index, :2] += by
        return Moments(replace(self._shown, positions=positions), self.scope, self._perceive)

    def within(self, scope: Scope) -> Moments:
        """Return those of a part of this part."""
        inner = Moments(self._shown, scope, self._perceive)
        inner._states = self._states
        return inner

    @cached_property
    def phases(self) -> list[Scope]:
        return self._shown.phases(self.scope)

    @cached_property
    def ends(self) -> list[State]:
        """Return the state at the end of each phase, when everything has come to rest."""
        return [self.state(end - 1) for _, end in self.phases]

    @cached_property
    def acts(self) -> list[Act]:
        found: list[Act] = []
        for number, (phase, after) in enumerate(zip(self.phases, self.phases[1:], strict=False)):
            arrival = self._arrival(*phase)
            left = found[-1].end if found else phase[0]
            before, later = self._before(arrival, phase[1]), self._after(*after)
            changed = frozenset[DeclaredFact]()
            if self._shown.closed[phase[1] - 1] == self._shown.closed[after[0]]:  # a fact has changed
                arrived, end = max(left, self._rest(*phase)), after[0] + 1
                changed = self._shown.changed(after[0])
            else:
                arrived = max(left, self._stop(arrival, phase[1], arrival))
                end = self._departure(*after)
            found.append(Act(number, after[0], phase[0], before, later, left, arrived, end, changed))
        return found

    def _arrival(self, begin: int, end: int) -> int:
        """Return the first frame of a phase from which on the hand is where it will act."""
        hand = self._shown.demonstration.grippers[begin:end, :2]
        away = np.flatnonzero(np.linalg.norm(hand - hand[-1], axis=1) > ARRIVED)
        return begin + (int(away[-1]) + 1 if len(away) else 0)

    def _departure(self, begin: int, end: int) -> int:
        """Return the first frame of a phase in which the hand has left the place where it acted."""
        hand = self._shown.demonstration.grippers[begin:end, :2]
        away = np.flatnonzero(np.linalg.norm(hand - hand[0], axis=1) > ARRIVED)
        closed = self._shown.closed
        if not len(away) and (end == self.scope[1] or closed[end - 1] == closed[end]):
            return min(end, max(begin + SETTLED, self._rest(begin, end)))  # it stays
        gone = begin + int(away[0]) if len(away) else end
        return self._stop(begin, gone, gone)

    def _rest(self, begin: int, end: int) -> int:
        """Return the first frame after the hand has come to rest where it is in the end; where it has not
        moved, the first of all.
        """
        hand = self._shown.demonstration.grippers[begin:end]
        moving = np.flatnonzero(np.linalg.norm(hand - hand[-1], axis=1) > RESTING)
        return min(end, begin + int(moving[-1]) + 1 + SETTLED) if len(moving) else begin

    def _stop(self, begin: int, end: int, otherwise: int) -> int:
        """Return the first frame after the hand, while it is up, has been slowest.

        A motion begins and ends at rest: so it is told where coming, acting and going meet.

        Args:
            otherwise: returned where the hand is not lifted.
        """
        heights = self._shown.demonstration.grippers[begin:end, 2]
        if not len(heights) or np.ptp(heights) < LIFTED:
            return otherwise
        up = heights >= (heights.min() + heights.max()) / 2
        speeds = np.where(up, self._speeds[begin:end], np.inf)
        return begin + int(np.flatnonzero(speeds <= speeds.min() + STILL)[-1]) + 1

    @cached_property
    def _speeds(self) -> NDArray[np.float64]:
        """Return how fast the hand is in each frame, (T,) [m/s]."""
        demonstration = self._shown.demonstration
        times, hand = demonstration.times.astype(float), demonstration.grippers
        count = np.arange(len(times))
        first = np.minimum(np.searchsorted(times, times - SPAN - 1e-6), np.maximum(count - 1, 0))
        last = np.searchsorted(times, times + SPAN + 1e-6) - 1
        last = np.maximum(last, np.minimum(count + 1, len(times) - 1))
        spent = np.maximum(times[last] - times[first], 1e-6)
        return np.asarray(np.linalg.norm(hand[last] - hand[first], axis=1) / spent)

    @staticmethod
    def _before(arrival: int, end: int) -> tuple[int, ...]:
        """Return some frames of a phase from when the hand is where it will act."""
        looks = np.linspace(arrival, end - 1, min(LOOKS, end - arrival)).round().astype(int)
        return tuple(dict.fromkeys(looks.tolist()))

    def _after(self, begin: int, end: int) -> tuple[int, ...]:
        return tuple(dict.fromkeys([end - 1, min(begin + 2, end - 1), begin]))
