"""One or two traces as a page for a browser: one file that fetches nothing and executes nothing of a trace.

The traces are JSON in a block that browsers do not execute, and the script inserts them as text only. The
content security policy permits this script and this style alone, by their hashes, and forbids the network.
"""

from __future__ import annotations

import json
import re
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING

import msgspec
from msgspec.structs import replace as with_fields

from ntp_dsl.common.text import printable
from ntp_dsl.traces.comparison.comparison import Comparison, Divergence
from ntp_dsl.traces.comparison.comparison_rules import DivergenceKind
from ntp_dsl.traces.comparison.divergence import compare
from ntp_dsl.traces.decision import Frames
from ntp_dsl.traces.explanation import interesting
from ntp_dsl.traces.overview import overview
from ntp_dsl.traces.page.document import (
    NO_ROW,
    PageDemonstration,
    PageDivergence,
    PageDocument,
    PageRow,
    PageTrace,
)
from ntp_dsl.traces.page.page_calls import Texts, page_call
from ntp_dsl.traces.page.page_parts import content_hash, joined
from ntp_dsl.traces.page.page_rows import page_rows
from ntp_dsl.traces.page.page_scene import demonstrated_scene, episode_scene
from ntp_dsl.traces.phrases import format_call, format_invocation, format_scope, headline
from ntp_dsl.traces.schema import ROOT, DemonstratedCall
from ntp_dsl.traces.sources import statement
from ntp_dsl.traces.times import inclusive_times
from ntp_dsl.traces.trace import Trace

if TYPE_CHECKING:
    from ntp_dsl.demonstrations.demonstration import Demonstration

PARTS = Path(__file__).parent / "viewer"
SCRIPTS = ("model.js", "tree.js", "detail.js", "scene.js", "timeline.js", "main.js")
LIVE = (*SCRIPTS, "live.js")  # of a run that goes on
PLACE = re.compile(r"\{(policy|title|style|script|data)\}")  # of a part of the page


def page(
    comparison: Comparison, folders: tuple[Path, ...], demonstration: Demonstration | None = None
) -> str:
    """Return the page of a comparison; see `page_document`."""
    return _render(comparison.a.header.task, page_document(comparison, folders, demonstration))


def live_page(trace: Trace, folder: Path, demonstration: Demonstration | None) -> str:
    """Return the page of a run that goes on, which may ask for what lies beside it, such as `events`."""
    document = live_document(trace, folder, demonstration, waits_for="", goes_on=True)
    return _render(trace.header.task, document, LIVE, "connect-src 'self'; ")


def live_document(
    trace: Trace, folder: Path, demonstration: Demonstration | None, waits_for: str, goes_on: bool
) -> PageDocument:
    """Return what the page of a run shows.

    Args:
        waits_for: the decision before which it waits, as text; empty where it does not wait.
        goes_on: it is not over.
    """
    document = page_document(compare(trace, trace), (folder,), demonstration, goes_on)
    return with_fields(document, waits_for=waits_for)


def encoded(document: PageDocument) -> str:
    """Return a document as JSON."""
    return json.dumps(msgspec.to_builtins(document), separators=(",", ":"), allow_nan=False)


def page_document(
    comparison: Comparison,
    folders: tuple[Path, ...],
    demonstration: Demonstration | None = None,
    goes_on: bool = False,
) -> PageDocument:
    """Return what a page shows of a comparison; that of a trace with itself shows one trace.

    Args:
        folders: of the traces, where their pictures are.
        demonstration: shows its scene, and when the hand was closed.
        goes_on: the run is not over.
    """
    alone = comparison.a is comparison.b
    traces = (comparison.a,) if alone else (comparison.a, comparison.b)
    texts = Texts()
    sides = [_trace(trace, folder, texts, goes_on) for trace, folder in zip(traces, folders, strict=False)]
    rows = page_rows(comparison)
    divergences = () if alone else comparison.divergences
    failed = alone and comparison.a.end is not None and comparison.a.end.success is False
    asked = interesting(comparison.a) if failed else None
    return PageDocument(
        summary=verdict(comparison.a, goes_on) if alone else comparison.summary,
        texts=texts.all,
        traces=sides,
        rows=rows,
        divergences=[_divergence(comparison, each, rows) for each in divergences],
        frames=max([1, *(side.frames for side in sides)]),
        demonstration=_demonstration(comparison.a, demonstration),
        overview=" ".join(overview(comparison.a)[1:]) if failed else "",  # its verdict is in the summary
        begins_at=next((n for n, row in enumerate(rows) if asked is not None and row.a == asked.id), 0),
        goes_on=goes_on,
    )


def waiting_page() -> str:
    """Return what a browser shows before a run has begun; it asks again every second."""
    style = joined(PARTS, ("palette.css",))
    layout = (
        "margin: 0; height: 100vh; display: grid; place-content: center; font: 1.1rem system-ui, sans-serif"
    )
    return f"""<!doctype html><html lang="en"><meta charset="utf-8"><meta http-equiv="refresh" content="1">
<title>ntp run: not begun</title>
<style>{style} body {{ {layout}; background: var(--back); color: var(--text); }}</style>
<p>The run has not begun. This page asks again every second."""


def _render(title: str, document: PageDocument, scripts: tuple[str, ...] = SCRIPTS, network: str = "") -> str:
    style, script = joined(PARTS, ("palette.css", "page.css")), joined(PARTS, scripts)
    hashes = f"script-src '{content_hash(script)}'; style-src '{content_hash(style)}'"
    policy = f"default-src 'none'; {hashes}; {network}img-src data:; base-uri 'none'; form-action 'none'"
    text = (PARTS / "page.html").read_text(encoding="utf-8")
    parts = {
        "policy": policy,
        "title": escape(title or "a trace"),
        "style": style,
        "script": script,
        "data": encoded(document).replace("<", "\\u003c"),  # so that no tag can end the block
    }
    return PLACE.sub(lambda found: parts[found[1]], text)


def verdict(trace: Trace, goes_on: bool = False) -> str:
    """Return who decided, and how that ended."""
    who = str(trace.header.policy or "a run")
    end = trace.end
    if end is None:
        return f"{who}: {'running' if goes_on else 'cut off'}"
    if end.success is None:
        judged = str(end.ending)
    elif end.success:
        judged = "success"
    else:
        judged = f"failed, attributed to {end.attributed_to}" if end.attributed_to else "failed"
    said = [end.verdict or end.reason] if not end.success else []
    return printable(f"{who}: {': '.join([judged, *filter(None, said)])}")


def _trace(trace: Trace, folder: Path, texts: Texts, goes_on: bool) -> PageTrace:
    times = inclusive_times(trace)
    frames = [call.end_frame or call.frame for call in trace.calls]
    return PageTrace(
        origin=headline(trace.header),
        ending=verdict(trace, goes_on),
        calls=[page_call(trace, call, times[call.id], texts) for call in trace.calls],
        scene=episode_scene(trace, str(trace.header.policy or "episode"), folder),
        frames=max([len(trace.motions), *frames], default=0) + 1,
    )


def _divergence(comparison: Comparison, divergence: Divergence, rows: list[PageRow]) -> PageDivergence:
    a, b = divergence.a, divergence.b
    is_answer = divergence.answer is not None
    return PageDivergence(
        kind=str(divergence.kind),
        attributed_to=divergence.attributed_to or "",
        row=_row(divergence, rows),
        a=_call_or_caller(a, divergence.caller_a),
        b=_call_or_caller(b, divergence.caller_b),
        did_a=_action(comparison.a, divergence, a),
        did_b=_answered_action(divergence) if is_answer else _action(comparison.b, divergence, b),
        source=divergence.source,
        statement=statement(comparison.a, divergence.source),
        margin=divergence.confidence.margin,
        rank=divergence.confidence.rank,
        differences=str(divergence.states or ""),
    )


def _row(divergence: Divergence, rows: list[PageRow]) -> int:
    """Return the row of the calls, the first where they have two; `NO_ROW` for the run itself.

    Where a trace returned instead, it is the other's call, and where both did, their caller.
    """
    a, b = divergence.a, divergence.b
    if a is None and b is None:
        a, b = divergence.caller_a, divergence.caller_b
    where = (
        number
        for number, row in enumerate(rows)
        if (a is not None and row.a == a) or (b is not None and row.b == b)
    )
    return next(where, NO_ROW)


def _call_or_caller(call: int | None, caller: int) -> int | None:
    """Return the call, or the caller that returned; None for the run itself."""
    return caller if call is None and caller != ROOT else call


def _action(trace: Trace, divergence: Divergence, number: int | None) -> str:
    if number is None:
        return "ends here" if divergence.kind is DivergenceKind.CUT_OFF else "returns"
    call = trace.calls[number]
    if divergence.kind is DivergenceKind.SCOPE:
        return f"calls {format_call(call)} with {format_scope(call.scope)}"
    shows_outcome = divergence.kind in (DivergenceKind.OUTCOME, DivergenceKind.CUT_OFF)
    return f"calls {format_call(call)}{f': {call.outcome}' if shows_outcome else ''}"


def _answered_action(divergence: Divergence) -> str:
    answer = divergence.answer
    assert answer is not None
    if answer.callee is None:
        return "would return"
    scope = f" with {format_scope(answer.scope)}" if divergence.kind is DivergenceKind.SCOPE else ""
    return f"would call {format_invocation(answer.callee, answer.arguments)}{scope}"


def _demonstration(trace: Trace, demonstration: Demonstration | None) -> PageDemonstration:
    reference = trace.header.demonstration
    scopes = [call.scope[1] for call in trace.calls if call.scope]
    return PageDemonstration(
        frames=max([1, *scopes, reference.frames if reference else 1]),
        calls=_top_level_calls(reference.calls) if reference and reference.calls else [],
        closed=_closed(demonstration) if demonstration is not None else [],
        scene=demonstrated_scene(demonstration) if demonstration is not None else None,
        said=trace.header.said,
    )


def _top_level_calls(tree: DemonstratedCall) -> list[tuple[str, Frames]]:
    return [
        (format_invocation(child.name, tuple(a for a in child.arguments if isinstance(a, str))), child.scope)
        for child in tree.children
    ]


def _closed(demonstration: Demonstration) -> list[Frames]:
    """Return the ranges of frames [begin, end) in which the hand was closed."""
    ranges: list[Frames] = []
    begin = None
    for frame, closed in enumerate([*demonstration.closed.tolist(), False]):
        if closed and begin is None:
            begin = frame
        elif not closed and begin is not None:
            ranges.append((begin, frame))
            begin = None
    return ranges
