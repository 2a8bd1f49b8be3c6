"""A trace laid out in time: its calls as nested slices, which contain those of deciding, planning and moving.

The clock runs through those times alone: other time that the world took is not counted.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from ntp_dsl.traces.schema import Call
from ntp_dsl.traces.trace import Trace

SHORTEST = 1  # [µs] of a slice, so that it is visible


@dataclass
class Slice:
    """A call, or a part of one, from its begin for its length [µs]."""

    call: Call
    part: str  # decide, plan or move; empty for the call as a whole
    above: int  # the call that it lies in, or ROOT
    begin: int
    length: int = 0

    @property
    def end(self) -> int:
        return self.begin + self.length


def slices(trace: Trace) -> list[Slice]:
    """Return the slices by begin: of two with one span, the outer one comes first.

    Deciding to make a call lies before it, in its caller; all else lies in the call itself.
    """
    clock = 0
    found: list[Slice] = []
    running: list[Slice] = []
    for call, returns in trace.events():
        parts = _before_return(call) if returns else {"decide": call.decision.seconds}
        for part, spent in parts.items():
            if spent:
                above = call.id if returns else call.parent
                found.append(Slice(call, part, above, clock, max(SHORTEST, round(1e6 * spent))))
                clock = found[-1].end
        if returns:
            clock = _close(running.pop(), clock)
        else:
            running.append(Slice(call, "", call.parent, clock))
            found.append(running[-1])
    for each in reversed(running):  # of a trace that was cut off
        clock = _close(each, clock)
    return found


def details(call: Call) -> dict[str, Any]:
    """Return what viewers show of a call."""
    facts = {
        "outcome": call.outcome or "cut off",
        "scope": call.scope,
        "probability": call.decision.probability,
        "source": call.decision.source or None,
        "frame": call.frame,
        "disturbances": list(call.execution.disturbances),
    }
    return {name: value for name, value in facts.items() if value not in (None, [])}


def _close(each: Slice, clock: int) -> int:
    """Set the length of a slice, at least the shortest, and return the clock at its end."""
    each.length = max(SHORTEST, clock - each.begin)
    return each.end


def _before_return(call: Call) -> Mapping[str, float]:
    if call.is_program:
        return {"decide": call.return_decision.seconds if call.return_decision else 0.0}
    return {"plan": call.execution.planning, "move": call.execution.moving}
