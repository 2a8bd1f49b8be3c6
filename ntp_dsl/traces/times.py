"""Where the time of a trace went: deciding, planning and moving, of each call and all below it."""

from __future__ import annotations

from dataclasses import dataclass

from ntp_dsl.traces.schema import ROOT, Call, Trace


@dataclass(frozen=True)
class Times:
    """Wall seconds. A decision counts for the call that it led to; one to return, for what returns."""

    deciding: float = 0.0
    planning: float = 0.0
    moving: float = 0.0

    def __add__(self, other: Times) -> Times:
        return Times(
            self.deciding + other.deciding,
            self.planning + other.planning,
            self.moving + other.moving,
        )

    @property
    def total(self) -> float:
        return self.deciding + self.planning + self.moving


def own(call: Call) -> Times:
    """Return a call's own times, without those of the calls below it."""
    returning = call.ending.seconds if call.ending else 0.0
    return Times(call.decision.seconds + returning, call.execution.planning, call.execution.moving)


def with_all_below(trace: Trace) -> list[Times]:
    """Return the times of every call and all below it, by the calls' numbers."""
    times = [own(call) for call in trace.calls]
    for call in reversed(trace.calls):
        if call.parent != ROOT:
            times[call.parent] = times[call.parent] + times[call.id]
    return times
