"""Rules for comparing traces: when two calls count as the same."""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import dataclass
from enum import StrEnum

from ntp_dsl.semantics.observation import Argument
from ntp_dsl.traces.decision import Frames
from ntp_dsl.traces.schema import Call, CallOutcome
from ntp_dsl.traces.trace import Trace

MIN_SCOPE_OVERLAP = 0.5  # intersection over union of two scopes that count as the same
NUMBER_TOLERANCE = 0.01  # between numbers that count as the same [SI]


class DivergenceKind(StrEnum):
    """How two traces differ."""

    PROGRAM = "program"  # a different callee
    ARGUMENT = "argument"  # the same callee with different arguments
    SCOPE = "scope"  # the same call with a different part of the demonstration
    TOO_EARLY = "end too early"  # the second returns where the first calls
    TOO_LATE = "end too late"  # the second calls where the first returns
    OUTCOME = "outcome"  # the same call with a different outcome
    CUT_OFF = "cut off"  # one of the traces was cut off here


@dataclass(frozen=True)
class Rules:
    """What is compared. Learned programs are not given lists, and do not distinguish done from unfinished."""

    lists: bool = True
    unfinished: bool = True  # whether done and unfinished are distinguished
    scopes: bool = True

    @classmethod
    def between(cls, a: Trace, b: Trace, scopes: bool = True) -> Rules:
        """Return the rules that fit both traces. Scopes are compared only where both have some."""
        scripted = not (a.is_learned or b.is_learned)
        both = all(any(call.scope is not None for call in each.calls) for each in (a, b))
        return cls(lists=scripted, unfinished=scripted, scopes=scopes and both)

    def label(self, call: Call) -> Hashable:
        """Return a key that is equal for calls that are the same but for their numbers."""
        return call.kind, call.name, tuple(map(_exact, self.arguments(call)))

    def arguments(self, call: Call) -> tuple[Argument, ...]:
        return tuple(a for a in call.arguments if self.lists or not isinstance(a, tuple))

    def outcome(self, call: Call) -> CallOutcome | None:
        """Return the outcome of a call, with all returns as done where they are not distinguished."""
        returned = call.outcome is not None and call.outcome.is_return
        return CallOutcome.DONE if returned and not self.unfinished else call.outcome

    def same_numbers(self, x: Call, y: Call) -> bool:
        """Whether the numbers of two calls with the same label are within tolerance."""
        pairs = zip(self.arguments(x), self.arguments(y), strict=True)
        return all(_near(a, b) for a, b in pairs)

    def same_scope(self, x: Call, y: Call) -> bool:
        """Whether two calls have the same scope. Primitives read no demonstration, so theirs do not count."""
        return not (self.scopes and x.is_program) or overlap(x.scope, y.scope) >= MIN_SCOPE_OVERLAP


def overlap(a: Frames | None, b: Frames | None) -> float:
    """Return intersection over union of two scopes; 1 where both are missing."""
    if a is None or b is None or a == b:
        return float(a == b)
    both = min(a[1], b[1]) - max(a[0], b[0])
    either = max(a[1], b[1]) - min(a[0], b[0])
    return max(0.0, both / either) if either else 1.0


def _exact(argument: Argument) -> Hashable:
    return "a number" if isinstance(argument, int | float) else argument


def _near(a: Argument, b: Argument) -> bool:
    if isinstance(a, int | float) and isinstance(b, int | float):
        return abs(a - b) <= NUMBER_TOLERANCE
    return True
