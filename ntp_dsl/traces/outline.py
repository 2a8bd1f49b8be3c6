"""A trace as an indented outline, and as a table of calls: what a notebook shows of it."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from ntp_dsl.traces.failure_attribution import attribute_call
from ntp_dsl.traces.phrases import format_call, headline, printable
from ntp_dsl.traces.schema import ROOT, Trace

if TYPE_CHECKING:
    import pandas

LINES = 60  # beyond so many, an outline is cut


def outline(trace: Trace) -> str:
    """Return the call tree, a line a call, with what each came to."""
    lines = list(_lines(trace))
    more = [f"... {len(lines) - LINES} more calls"] if len(lines) > LINES else []
    end = "cut off" if trace.end is None else printable(f"{trace.end.ending} {trace.end.verdict}".strip())
    return "\n".join([headline(trace), *lines[:LINES], *more, end])


def _lines(trace: Trace) -> Iterator[str]:
    for call, depth in zip(trace.calls, depths(trace), strict=True):
        sure = f"  p={p:.2f}" if (p := call.decision.probability) is not None else ""
        yield f"{'  ' * depth}{format_call(call)}  {call.outcome or 'cut off'}{sure}"


def depths(trace: Trace) -> list[int]:
    """Return how deep each call lies, the root's at 0."""
    found: list[int] = []
    for call in trace.calls:
        found.append(0 if call.parent == ROOT else found[call.parent] + 1)
    return found


def dataframe(trace: Trace) -> pandas.DataFrame:
    """Return a row for each call. Needs pandas, of the extra `notebook`."""
    import pandas

    rows = [
        {
            "id": call.id,
            "parent": call.parent,
            "depth": depth,
            "kind": str(call.kind),
            "name": call.name,
            "arguments": ", ".join(map(str, call.arguments)),
            "outcome": None if call.outcome is None else str(call.outcome),
            "attributed_to": None if (cause := attribute_call(call)) is None else str(cause),
            "probability": call.decision.probability,
            "scope_begin": None if call.scope is None else call.scope[0],
            "scope_end": None if call.scope is None else call.scope[1],
            "frame": call.frame,
            "end_frame": call.end_frame,
            "source": call.decision.source,
            "deciding_seconds": call.decision.seconds,
            "planning_seconds": call.execution.planning,
            "moving_seconds": call.execution.moving,
            "disturbances": ", ".join(call.execution.disturbances),
        }
        for call, depth in zip(trace.calls, depths(trace), strict=True)
    ]
    return pandas.DataFrame(rows).set_index("id")
