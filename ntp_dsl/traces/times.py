"""Where the time of a trace went: deciding, planning and moving, of each call and all below it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

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
    deciding = seconds(call.decision, "seconds") + seconds(call.ending, "seconds")
    return Times(deciding, seconds(call.details, "planning"), seconds(call.details, "moving"))


def with_all_below(trace: Trace) -> list[Times]:
    """By the calls' numbers."""
    times = [own(call) for call in trace.calls]
    for call in reversed(trace.calls):
        if call.parent != ROOT:
            times[call.parent] = times[call.parent] + times[call.id]
    return times


def seconds(facts: Mapping[str, Any], name: str) -> float:
    """What a line says that something took; nothing where it does not."""
    value = facts.get(name)
    return float(value) if isinstance(value, int | float) and 0 <= value < 1e9 else 0.0
