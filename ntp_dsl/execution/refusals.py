"""Calls in vain, each with the states in which it was made, so that none is repeated for ever."""

from __future__ import annotations

from dataclasses import dataclass
from math import dist

from ntp_dsl.semantics.observation import Argument, Observation

TRIES = 4  # of a call that fails by chance, in one state
UNCHANGED = 0.002  # [m] nothing has moved farther

Call = tuple[str | None, tuple[Argument, ...]]


@dataclass
class _Vain:
    """A call in a state: how often it was tried there, and whether it failed or had nothing to do."""

    state: Observation
    tries: int
    failed: bool


class Refusals:
    """The calls in vain, by call and state.

    A state that recurs is the same state: a cycle of calls, of which one always fails, ends as a call that
    fails in place does.
    """

    def __init__(self) -> None:
        self._by_call: dict[Call, list[_Vain]] = {}

    def __contains__(self, call: Call) -> bool:
        """Return whether a call was in vain in any state: a quick test."""
        return call in self._by_call

    def add(self, call: Call, state: Observation, failed: bool, by_chance: bool = False) -> None:
        """Add a call that changed nothing; one that failed `by_chance` may be tried `TRIES` times."""
        tries = 1 if by_chance else TRIES
        known = self._find(call, state)
        if known is None:
            self._by_call.setdefault(call, []).append(_Vain(state, tries, failed))
        else:
            known.tries, known.failed = known.tries + tries, failed

    def bars(self, call: Call, state: Observation) -> bool:
        """Return whether the call must not be made in this state."""
        known = self._find(call, state)
        return known is not None and known.tries >= TRIES

    def failed(self, call: Call, state: Observation) -> bool:
        """Return whether it is barred because it failed, not because it had nothing to do."""
        known = self._find(call, state)
        return known is not None and known.failed

    def _find(self, call: Call, state: Observation) -> _Vain | None:
        return next((each for each in self._by_call.get(call, ()) if not differ(each.state, state)), None)


def differ(a: Observation, b: Observation) -> bool:
    """Return whether the hand or any object has moved."""
    if a.closed != b.closed or a.unreachable != b.unreachable or a.positions.keys() != b.positions.keys():
        return True
    moved = (dist(a.positions[name], b.positions[name]) for name in a.positions)
    return max(dist(a.gripper, b.gripper), *moved) > UNCHANGED
