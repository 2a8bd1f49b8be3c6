"""One or two traces as a page for a browser: one file that fetches nothing and executes nothing of a trace.

The traces are JSON in a block that browsers do not execute, and the script inserts them as text only. The
content security policy permits this script and this style alone, by their hashes, and forbids the network.
"""

from __future__ import annotations

import json
from base64 import b64encode
from hashlib import sha256
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING

import msgspec

from ntp_dsl.traces.comparison.comparison import Comparison, Divergence
from ntp_dsl.traces.comparison.comparison_rules import DivergenceKind
from ntp_dsl.traces.decision import Frames
from ntp_dsl.traces.page.document import (
    NO_ROW,
    PageDemonstration,
    PageDivergence,
    PageDocument,
    PageRow,
    PageTrace,
)
from ntp_dsl.traces.page.page_calls import finite, motion, page_call
from ntp_dsl.traces.page.page_pictures import pictures
from ntp_dsl.traces.page.page_rows import page_rows
from ntp_dsl.traces.phrases import format_call, format_invocation, format_scope, headline
from ntp_dsl.traces.schema import ROOT, DemonstratedCall
from ntp_dsl.traces.sources import statement
from ntp_dsl.traces.times import inclusive_times
from ntp_dsl.traces.trace import Trace

if TYPE_CHECKING:
    from ntp_dsl.demonstrations.demonstration import Demonstration

PARTS = Path(__file__).parent / "viewer"
SCRIPTS = ("model.js", "tree.js", "detail.js", "scene.js", "timeline.js", "main.js")


def page(
    comparison: Comparison, folders: tuple[Path, ...], demonstration: Demonstration | None = None
) -> str:
    """Return the page of a comparison; that of a trace with itself shows one trace.

    Args:
        folders: of the traces, where their pictures are.
        demonstration: shows when the hand was closed.
    """
    alone = comparison.a is comparison.b
    traces = (comparison.a,) if alone else (comparison.a, comparison.b)
    sides = [_trace(trace, folder) for trace, folder in zip(traces, folders, strict=False)]
    rows = page_rows(comparison)
    divergences = () if alone else comparison.divergences
    document = PageDocument(
        summary=summary(comparison),
        traces=sides,
        rows=rows,
        divergences=[_divergence(comparison, each, rows) for each in divergences],
        frames=max([1, *(side.frames for side in sides)]),
        demonstration=_demonstration(comparison.a, demonstration),
    )
    return _render(comparison.a.header.task or "a trace", document)


def summary(comparison: Comparison) -> str:
    """Return the end of a single trace, or the first divergence of two, in a sentence."""
    first = comparison.first
    if comparison.a is comparison.b:
        return _end(comparison.a)
    if first is None:
        return "The two traces are the same."
    more = len(comparison.divergences) - 1
    others = f"; {more} more" if more else ""
    cause = f", attributed to {first.attributed_to}" if first.attributed_to else ""
    return f"First divergence: {first.kind}{cause}{others}."


def _render(title: str, document: PageDocument) -> str:
    style = (PARTS / "page.css").read_text(encoding="utf-8")
    script = "\n".join((PARTS / name).read_text(encoding="utf-8") for name in SCRIPTS)
    policy = (
        f"default-src 'none'; script-src '{_hash(script)}'; style-src '{_hash(style)}'; "
        "img-src data:; base-uri 'none'; form-action 'none'"
    )
    data = json.dumps(msgspec.to_builtins(document), separators=(",", ":"), allow_nan=False)
    text = (PARTS / "page.html").read_text(encoding="utf-8")
    parts = {"policy": policy, "title": escape(title), "style": style, "script": script}
    for name, part in parts.items():
        text = text.replace(f"{{{name}}}", part)
    return text.replace("{data}", data.replace("<", "\\u003c"))  # so that no tag can end the block


def _hash(text: str) -> str:
    return "sha256-" + b64encode(sha256(text.encode()).digest()).decode()


def _end(trace: Trace) -> str:
    if trace.end is None:
        return "The trace is cut off."
    parts = [trace.end.ending, trace.end.reason, trace.end.verdict]
    return ": ".join(each for each in parts if each)


def _trace(trace: Trace, folder: Path) -> PageTrace:
    times = inclusive_times(trace)
    frames = [call.end_frame or call.frame for call in trace.calls]
    return PageTrace(
        headline=headline(trace.header),
        calls=[page_call(trace, call, times[call.id]) for call in trace.calls],
        motion=motion(trace),
        sizes={each.name: each.size for each in trace.header.objects},
        pictures=[(each.frame, each.uri) for each in pictures(trace, folder)],
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
        state_distance=finite(divergence.state_distance),
    )


def _row(divergence: Divergence, rows: list[PageRow]) -> int:
    """Return the row of the call, or of the caller that returned; `NO_ROW` for the run itself."""
    if divergence.a is None and divergence.answer is None and divergence.b is not None:
        return next((number for number, row in enumerate(rows) if row.b == divergence.b), NO_ROW)
    call = divergence.caller_a if divergence.a is None else divergence.a
    return next((number for number, row in enumerate(rows) if row.a == call), NO_ROW)


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
