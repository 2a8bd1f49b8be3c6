"""Calls of a trace as lines of a terminal, and as rows of JSON."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from rich.text import Text

from ntp_dsl.common.text import printable
from ntp_dsl.traces.failure_attribution import attribute_call
from ntp_dsl.traces.phrases import format_call
from ntp_dsl.traces.schema import Call
from ntp_dsl.traces.times import Times
from ntp_dsl.traces.trace import Trace

BAR = 12  # [characters] for the whole demonstration
COLOURS = {"done": "green", "achieved": "green", "unfinished": "yellow"}


def line(call: Call, frames: int, times: Times) -> Text:
    """Return a call as a line: arguments, scope, outcome, probability and time."""
    name, rest = format_call(call).split("(", 1)
    text = Text(name, style="bold" if call.is_program else "cyan")
    text.append(f"({rest}", style="default not bold")
    text.append(f"  {scope_bar(call, frames)}  ", style="blue not bold")
    outcome = call.outcome or "cut off"
    text.append(outcome, style=f"{COLOURS.get(outcome, 'red')} not bold")
    if call.execution.unmet:
        text.append(f"  but not {printable(', '.join(call.execution.unmet))}", style="red not bold")
    if call.decision.probability is not None:
        text.append(f"  p={call.decision.probability:.2f}", style="dim not bold")
    if time := duration(times):
        text.append(f"  {time}", style="dim not bold")
    for disturbance in call.execution.disturbances:
        text.append(f"  [{printable(disturbance)}]", style="magenta not bold")
    return text


def scope_bar(call: Call, frames: int) -> str:
    """Return the scope of a call as a bar over the demonstration; dots where it has none."""
    if call.scope is None:
        return "·" * BAR
    begin, end = (round(BAR * frame / frames) for frame in call.scope)
    begin = min(begin, BAR - 1)
    end = min(max(end, begin + 1), BAR)
    return "─" * begin + "█" * (end - begin) + "─" * (BAR - end)


def demonstration_frames(trace: Trace) -> int:
    """Return the length of the demonstration, or the end of the last scope where it is unknown."""
    known = trace.header.demonstration.frames if trace.header.demonstration else 1
    return max([1, known, *(call.scope[1] for call in trace.calls if call.scope)])


def duration(times: Times) -> str:
    """Return the times of a millisecond or more as text."""
    parts = {"decide": times.deciding, "plan": times.planning, "move": times.moving}
    return " ".join(f"{name} {seconds(spent)}" for name, spent in parts.items() if spent >= 0.0005)


def seconds(value: float) -> str:
    """Return a duration as text, in seconds or milliseconds."""
    return f"{value:.1f} s" if value >= 1 else f"{1000 * value:.0f} ms"


def as_json(call: Call, times: Times) -> Mapping[str, Any]:
    """Return a call as a row of JSON."""
    return {
        "id": call.id,
        "parent": call.parent,
        "kind": call.kind,
        "name": call.name,
        "arguments": call.arguments,
        "scope": call.scope,
        "outcome": call.outcome or "",
        "attributed_to": attribute_call(call),
        "probability": call.decision.probability,
        "source": call.decision.source,
        "seconds": {
            "deciding": round(times.deciding, 5),
            "planning": round(times.planning, 5),
            "moving": round(times.moving, 5),
        },
        "disturbances": call.execution.disturbances,
        "unmet": call.execution.unmet,
    }
