"""Calls that lead to nothing, each with the states in which it was made: none is repeated for ever."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum, auto
from math import acos, dist

from ntp_dsl.semantics.geometry import Quaternion, Vector
from ntp_dsl.semantics.observation import Argument, Observation

TRIES = 4  # of a call that fails by chance, in one state
ROUNDS = 8  # of a call that changes something, but comes back to one state
UNCHANGED = 0.002  # [m] nothing has moved farther
UNTURNED = 0.05  # [rad] nothing has turned farther

Call = tuple[str | None, tuple[Argument, ...]]


class InVain(Enum):
    """Why a call leads to nothing."""

    FAILED = auto()
    NEEDLESS = auto()  # it returned done or achieved, and nothing had to be changed
    CIRCULAR = auto()  # it comes round to the state in which it was made


@dataclass
class _Made:
    """A call in a state: how often it was made there, and what came of it."""

    state: Observation
    times: int
    why: InVain


class Refusals:
    """Calls by state: after so many `tries` in one state, a call is refused there.

    A state that recurs is the same state: a cycle of calls, of which one always fails, ends as a call that
    fails in place does.
    """

    def __init__(self, tries: int = TRIES) -> None:
        self._tries = tries
        self._by_call: dict[Call, list[_Made]] = {}

    def __contains__(self, call: Call) -> bool:
        """Return whether a call was made in any state: a quick test."""
        return call in self._by_call

    def add(self, call: Call, state: Observation, why: InVain, by_chance: bool = False) -> None:
        """Add a call; only what came about `by_chance` may be tried again in this state."""
        times = 1 if by_chance else self._tries
        known = self._find(call, state)
        if known is None:
            self._by_call.setdefault(call, []).append(_Made(state, times, why))
        else:
            known.times, known.why = known.times + times, why

    def barred(self, call: Call, state: Observation) -> InVain | None:
        """Return why the call must not be made in this state; None where it may be."""
        known = self._find(call, state)
        return known.why if known is not None and known.times >= self._tries else None

    def _find(self, call: Call, state: Observation) -> _Made | None:
        return next((each for each in self._by_call.get(call, ()) if not differ(each.state, state)), None)


def differ(a: Observation, b: Observation) -> bool:
    """Return whether the hand or any object has moved or turned, or a fact of the state has changed."""
    return (
        _moved(a.gripper, b.gripper)
        or a.closed != b.closed
        or a.facts != b.facts
        or a.unreachable != b.unreachable
        or a.positions.keys() != b.positions.keys()
        or any(_moved(at, b.positions[name]) for name, at in a.positions.items())
        or any(_turned(a.orientation(name), b.orientation(name)) for name in a.positions)
    )


def _moved(a: Vector, b: Vector) -> bool:
    return a != b and dist(a, b) > UNCHANGED


def _turned(a: Quaternion, b: Quaternion) -> bool:
    if a == b:
        return False
    same = abs(sum(x * y for x, y in zip(a, b, strict=True)))
    return 2 * acos(min(1.0, same)) > UNTURNED
