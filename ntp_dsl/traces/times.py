"""Time spent on deciding, planning and moving, for each call alone and with all calls below it."""

from __future__ import annotations

from dataclasses import dataclass

from ntp_dsl.traces.schema import ROOT, Call
from ntp_dsl.traces.trace import Trace


@dataclass(frozen=True)
class Times:
    """Wall time [s]. A decision counts towards the call that it made or the program that it ended."""

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


def own_times(call: Call) -> Times:
    """Return the times of a call without those of the calls below it."""
    returning = call.return_decision.seconds if call.return_decision else 0.0
    return Times(call.decision.seconds + returning, call.execution.planning, call.execution.moving)


def inclusive_times(trace: Trace) -> list[Times]:
    """Return the times of each call with all calls below it, by number."""
    times = [own_times(call) for call in trace.calls]
    for call in reversed(trace.calls):
        if call.parent != ROOT:
            times[call.parent] = times[call.parent] + times[call.id]
    return times
