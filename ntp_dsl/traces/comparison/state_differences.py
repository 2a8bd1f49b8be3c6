"""How far apart two states are, object by object."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from math import dist, inf

from ntp_dsl.common.text import printable
from ntp_dsl.semantics.geometry import Vector
from ntp_dsl.semantics.observation import Observation

NAMED = 3  # objects that a text names
LEAST = 5e-4  # [m] that is worth telling
HAND = "the hand"


@dataclass(frozen=True)
class Displacement:
    """How far an object, or the hand, is off in the second state."""

    name: str
    offset: Vector  # from the first state to the second, world frame [m]

    @property
    def distance(self) -> float:
        """Return how far it is off [m]."""
        return dist(self.offset, (0, 0, 0))

    def __str__(self) -> str:
        axes = [
            f"{axis} {1000 * by:+.0f}"
            for axis, by in zip("xyz", self.offset, strict=True)
            if abs(by) >= LEAST
        ]
        direction = f" ({', '.join(axes)})" if len(axes) > 1 else ""
        return f"{printable(self.name)} {1000 * self.distance:.0f} mm off{direction}"


@dataclass(frozen=True)
class StateDifferences:
    """What differs between two states, A and B."""

    apart: tuple[Displacement, ...]  # the farthest first
    only_in_a: tuple[str, ...] = ()  # objects, and facts of the state
    only_in_b: tuple[str, ...] = ()
    hand_closed: str = ""  # "A" or "B" where the hand is closed in one alone

    @property
    def largest(self) -> float:
        """Return the largest distance [m]; infinite where an object is missing or one hand is closed."""
        if self.only_in_a or self.only_in_b or self.hand_closed:
            return inf
        return self.apart[0].distance if self.apart else 0.0

    def __str__(self) -> str:
        return "; ".join(self._parts())

    def _parts(self) -> Iterator[str]:
        told = [each for each in self.apart if each.distance >= LEAST]
        if told:
            more = [f"{len(told) - NAMED} more"] if len(told) > NAMED else []
            yield ", ".join([*map(str, told[:NAMED]), *more])
        for side, names in (("A", self.only_in_a), ("B", self.only_in_b)):
            if names:
                yield f"only {side} has {printable(', '.join(names[:NAMED]))}"
        if self.hand_closed:
            yield f"the hand is closed in {self.hand_closed} alone"


def _facts(own: Observation, other: Observation) -> Iterator[str]:
    """Yield the facts of the state that hold in one of two states alone."""
    for predicate, arguments in sorted(own.facts - other.facts):
        yield f"{predicate}({', '.join(arguments)})"


def state_differences(a: Observation | None, b: Observation | None) -> StateDifferences | None:
    """Return what differs between two states; None where one is unknown."""
    if a is None or b is None:
        return None
    both = [(HAND, a.gripper, b.gripper)]
    both += [(name, at, b.positions[name]) for name, at in a.positions.items() if name in b.positions]
    apart = [Displacement(name, (q[0] - p[0], q[1] - p[1], q[2] - p[2])) for name, p, q in both]
    return StateDifferences(
        tuple(sorted(apart, key=lambda each: -each.distance)),
        (*(name for name in a.positions if name not in b.positions), *_facts(a, b)),
        (*(name for name in b.positions if name not in a.positions), *_facts(b, a)),
        "" if a.closed == b.closed else "A" if a.closed else "B",
    )
