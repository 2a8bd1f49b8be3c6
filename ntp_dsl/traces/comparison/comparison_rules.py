"""When two calls count as the same: the rules by which traces are compared."""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import dataclass
from enum import StrEnum

from ntp_dsl.semantics.observation import Argument
from ntp_dsl.traces.decision import Frames
from ntp_dsl.traces.schema import Call, CallOutcome, Trace

OVERLAP = 0.5  # of two scopes that count as one: frames in both, over frames in either
NEAR = 0.01  # numbers that count as one [m], or whatever their unit is


class Kind(StrEnum):
    """How two traces part."""

    PROGRAM = "program"  # another callee
    ARGUMENT = "argument"  # the same callee, called on something else
    SCOPE = "scope"  # the same call, given another part of the demonstration
    TOO_EARLY = "end too early"  # the second returns where the first calls
    TOO_LATE = "end too late"  # the second calls where the first returns
    OUTCOME = "outcome"  # the same call came to something else
    CUT_OFF = "cut off"  # one of the files ends here


@dataclass(frozen=True)
class Rules:
    """What is compared. A learned program is given no lists, and cannot tell done from unfinished."""

    lists: bool = True
    unfinished: bool = True  # whether done and unfinished are told apart
    scopes: bool = True

    @classmethod
    def between(cls, a: Trace, b: Trace, scopes: bool = True) -> Rules:
        scripted = not (a.is_learned or b.is_learned)
        return cls(lists=scripted, unfinished=scripted, scopes=scopes)

    def label(self, call: Call) -> Hashable:
        """Two calls are one decision if their labels are the same, and their numbers near."""
        return call.kind, call.name, tuple(map(_exact, self.arguments(call)))

    def arguments(self, call: Call) -> tuple[Argument, ...]:
        return tuple(a for a in call.arguments if self.lists or not isinstance(a, tuple))

    def outcome(self, call: Call) -> CallOutcome | None:
        """Return what a call came to; a learned program's returns are all one."""
        returned = call.outcome is not None and call.outcome.is_return
        return CallOutcome.DONE if returned and not self.unfinished else call.outcome

    def same_numbers(self, x: Call, y: Call) -> bool:
        """Of calls with one label."""
        pairs = zip(self.arguments(x), self.arguments(y), strict=True)
        return all(_near(a, b) for a, b in pairs)

    def same_scope(self, x: Call, y: Call) -> bool:
        """Primitives read no demonstration, so theirs do not count."""
        return not (self.scopes and x.is_program) or overlap(x.scope, y.scope) >= OVERLAP


def overlap(a: Frames | None, b: Frames | None) -> float:
    """Frames in both over frames in either; none is all of none."""
    if a is None or b is None or a == b:
        return float(a == b)
    both = min(a[1], b[1]) - max(a[0], b[0])
    either = max(a[1], b[1]) - min(a[0], b[0])
    return max(0.0, both / either) if either else 1.0


def _exact(argument: Argument) -> Hashable:
    return "a number" if isinstance(argument, int | float) else argument


def _near(a: Argument, b: Argument) -> bool:
    if isinstance(a, int | float) and isinstance(b, int | float):
        return abs(a - b) <= NEAR
    return True
