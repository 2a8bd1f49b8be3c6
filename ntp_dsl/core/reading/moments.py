"""The states of a demonstration that a reading looks at: a few before and after each act of the hand."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ntp_dsl.core.perception.steadied import Steadied
from ntp_dsl.core.reading.likelihood import Perceive, Places, places
from ntp_dsl.demonstrations.demonstration import Scope
from ntp_dsl.semantics.state import State

ARRIVED = 0.012  # of the hand from where it will act, seen from above [m]
LOOKS = 5  # between its arrival and the act, at most


@dataclass(frozen=True)
class Act:
    """The hand closes or opens: the frames that lead to it, and those that show what came of it."""

    number: int  # among those of its part of the demonstration
    frame: int  # the first after it
    start: int  # of the phase before it
    before: tuple[int, ...]  # when the hand is where it acts, in their order
    after: tuple[int, ...]


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
            yield from (act.start, *act.before[:2])

    def beside(self, frame: int, item: str) -> Places:
        """Return the states that a frame would show if an object lay a little beside where it does."""
        return places(self.state(frame), item, self._perceive)

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
        pairs = zip(self.phases, self.phases[1:], strict=False)
        return [
            Act(number, after[0], phase[0], self._before(*phase), self._after(*after))
            for number, (phase, after) in enumerate(pairs)
        ]

    def _before(self, begin: int, end: int) -> tuple[int, ...]:
        """Return some frames of a phase from when the hand is where it will act."""
        hand = self._shown.demonstration.grippers[begin:end, :2]
        away = np.flatnonzero(np.linalg.norm(hand - hand[-1], axis=1) > ARRIVED)
        arrival = begin + (int(away[-1]) + 1 if len(away) else 0)
        looks = np.linspace(arrival, end - 1, min(LOOKS, end - arrival)).round().astype(int)
        return tuple(dict.fromkeys(looks.tolist()))

    def _after(self, begin: int, end: int) -> tuple[int, ...]:
        return tuple(dict.fromkeys([end - 1, min(begin + 2, end - 1), begin]))
