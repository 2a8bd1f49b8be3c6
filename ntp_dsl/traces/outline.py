"""A trace as an indented outline, and as a table of calls: what a notebook shows of it."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

from ntp_dsl.common.text import printable
from ntp_dsl.traces.failure_attribution import attribute_call
from ntp_dsl.traces.phrases import format_call, headline
from ntp_dsl.traces.schema import ROOT, Call, End, Header

if TYPE_CHECKING:
    import pandas

LINES = 60  # beyond so many, an outline is cut


def outline(header: Header, calls: Sequence[Call], end: End | None) -> str:
    """Return the call tree, a line a call, with what each came to."""
    lines = list(_lines(calls))
    more = [f"... {len(lines) - LINES} more calls"] if len(lines) > LINES else []
    ended = "cut off" if end is None else printable(f"{end.ending} {end.verdict}".strip())
    return "\n".join([headline(header), *lines[:LINES], *more, ended])


def _lines(calls: Sequence[Call]) -> Iterator[str]:
    for call, depth in zip(calls, depths(calls), strict=True):
        sure = f"  p={p:.2f}" if (p := call.decision.probability) is not None else ""
        yield f"{'  ' * depth}{format_call(call)}  {call.outcome or 'cut off'}{sure}"


def depths(calls: Sequence[Call]) -> list[int]:
    """Return how deep each call lies, the root's at 0."""
    found: list[int] = []
    for call in calls:
        found.append(0 if call.parent == ROOT else found[call.parent] + 1)
    return found


def dataframe(calls: Sequence[Call]) -> pandas.DataFrame:
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
        for call, depth in zip(calls, depths(calls), strict=True)
    ]
    return pandas.DataFrame(rows).set_index("id")
