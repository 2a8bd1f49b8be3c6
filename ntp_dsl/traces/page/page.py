"""One or two traces as a page for a browser: one file, nothing fetched, nothing of a trace carried out.

What a trace says travels as JSON in a block that no browser executes, and becomes text there; the policy in
the page's head lets only this script and this style run, by their hashes, and forbids the network.
"""

from __future__ import annotations

import json
from base64 import b64encode
from collections.abc import Mapping
from hashlib import sha256
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ntp_dsl.traces.comparison.comparison import Comparison, Divergence
from ntp_dsl.traces.comparison.comparison_rules import Kind
from ntp_dsl.traces.page.page_calls import call_row, motion, number
from ntp_dsl.traces.page.page_pictures import pictures
from ntp_dsl.traces.page.page_rows import rows
from ntp_dsl.traces.phrases import called, headline, in_words, scope_in_words
from ntp_dsl.traces.schema import ROOT, DemonstratedCall, Trace
from ntp_dsl.traces.sources import statement
from ntp_dsl.traces.times import with_all_below

if TYPE_CHECKING:
    from ntp_dsl.demonstrations.demonstration import Demonstration

PARTS = Path(__file__).parent / "viewer"
SCRIPTS = ("model.js", "tree.js", "detail.js", "scene.js", "timeline.js", "main.js")


def page(
    comparison: Comparison, folders: tuple[Path, ...], demonstration: Demonstration | None = None
) -> str:
    """The page's text. A comparison of a trace with itself shows that one. Pictures lie in the folders."""
    alone = comparison.a is comparison.b
    traces = (comparison.a,) if alone else (comparison.a, comparison.b)
    sides = [_trace(trace, folder) for trace, folder in zip(traces, folders, strict=False)]
    told = rows(comparison)
    parted = () if alone else comparison.divergences
    document = {
        "summary": summary(comparison),
        "traces": sides,
        "rows": told,
        "divergences": [_divergence(comparison, each, told) for each in parted],
        "frames": max([1, *(side["frames"] for side in sides)]),
        "demonstration": _demonstration(comparison.a, demonstration),
    }
    return _assembled(_title(comparison.a), document)


def summary(comparison: Comparison) -> str:
    first = comparison.first
    if comparison.a is comparison.b:
        return _ended(comparison.a)
    if first is None:
        return "The two traces are the same."
    more = len(comparison.divergences) - 1
    others = f"; {more} more" if more else ""
    cause = f", attributed to {first.attributed_to}" if first.attributed_to else ""
    return f"First divergence: {first.kind}{cause}{others}."


def _assembled(title: str, document: Mapping[str, Any]) -> str:
    style = (PARTS / "page.css").read_text(encoding="utf-8")
    script = "\n".join((PARTS / name).read_text(encoding="utf-8") for name in SCRIPTS)
    policy = (
        f"default-src 'none'; script-src '{_hash(script)}'; style-src '{_hash(style)}'; "
        "img-src data:; base-uri 'none'; form-action 'none'"
    )
    data = json.dumps(document, separators=(",", ":"), allow_nan=False)
    text = (PARTS / "page.html").read_text(encoding="utf-8")
    parts = {"policy": policy, "title": escape(title), "style": style, "script": script}
    for name, part in parts.items():
        text = text.replace(f"{{{name}}}", part)
    return text.replace("{data}", data.replace("<", "\\u003c"))  # so that no tag can end the block


def _hash(text: str) -> str:
    return "sha256-" + b64encode(sha256(text.encode()).digest()).decode()


def _title(trace: Trace) -> str:
    return trace.header.task or "a trace"


def _ended(trace: Trace) -> str:
    if trace.end is None:
        return "The trace is cut off."
    told = [trace.end.ending, trace.end.reason, trace.end.verdict]
    return ": ".join(each for each in told if each)


def _trace(trace: Trace, folder: Path) -> dict[str, Any]:
    times = with_all_below(trace)
    frames = [call.end_frame or call.frame for call in trace.calls]
    return {
        "headline": headline(trace),
        "calls": [call_row(trace, call, times[call.id]) for call in trace.calls],
        "motion": motion(trace),
        "sizes": {each.name: each.size for each in trace.header.objects},
        "pictures": [(each.frame, each.uri) for each in pictures(trace, folder)],
        "frames": max([len(trace.motions), *frames], default=0) + 1,
    }


def _divergence(comparison: Comparison, found: Divergence, told: list[dict[str, Any]]) -> dict[str, Any]:
    return {
        "kind": str(found.kind),
        "attributed_to": found.attributed_to or "",
        "row": _row(found, told),
        "a": _then(found.a, found.caller_a),
        "b": _then(found.b, found.caller_b),
        "did_a": _did(comparison.a, found, found.a),
        "did_b": _did(comparison.b, found, found.b) if found.answer is None else _would(found),
        "source": found.source,
        "statement": statement(comparison.a, found.source),
        "margin": found.confidence.margin,
        "rank": found.confidence.rank,
        "apart": number(found.apart),
    }


def _row(found: Divergence, told: list[dict[str, Any]]) -> int:
    """The row of the call, or of the caller that returned; −1 for the run itself."""
    side, wanted = ("b", found.b) if found.a is None and found.answer is None else ("a", found.a)
    if wanted is None:
        side, wanted = "a", found.caller_a
    return next((place for place, row in enumerate(told) if row[side] == wanted), -1)


def _then(call: int | None, caller: int) -> int | None:
    """The call, or the caller that returned; nothing where that is the run itself."""
    return caller if call is None and caller != ROOT else call


def _did(trace: Trace, found: Divergence, call: int | None) -> str:
    if call is None:
        return "ends here" if found.kind is Kind.CUT_OFF else "returns"
    made = trace.calls[call]
    if found.kind is Kind.SCOPE:
        return f"calls {in_words(made)} with {scope_in_words(made.scope)}"
    came_to = found.kind in (Kind.OUTCOME, Kind.CUT_OFF)
    return f"calls {in_words(made)}{f': {made.outcome}' if came_to else ''}"


def _would(found: Divergence) -> str:
    answer = found.answer
    assert answer is not None
    if answer.callee is None:
        return "would return"
    scope = f" with {scope_in_words(answer.scope)}" if found.kind is Kind.SCOPE else ""
    return f"would call {called(answer.callee, answer.arguments)}{scope}"


def _demonstration(trace: Trace, shown: Demonstration | None) -> dict[str, Any]:
    """Return how long it is, the calls that it shows below the root, and when the hand was closed."""
    facts = trace.header.demonstration
    scopes = [call.scope[1] for call in trace.calls if call.scope]
    return {
        "frames": max([1, *scopes, facts.frames if facts else 1]),
        "calls": _shown(facts.calls) if facts and facts.calls else [],
        "closed": _closed(shown) if shown is not None else [],
    }


def _shown(tree: DemonstratedCall) -> list[tuple[str, tuple[int, int]]]:
    return [
        (called(child.name, tuple(a for a in child.arguments if isinstance(a, str))), child.scope)
        for child in tree.children
    ]


def _closed(shown: Demonstration) -> list[tuple[int, int]]:
    """Stretches of frames [begin, end) in which the hand was closed."""
    stretches: list[tuple[int, int]] = []
    begin = None
    for frame, closed in enumerate([*shown.closed.tolist(), False]):
        if closed and begin is None:
            begin = frame
        elif not closed and begin is not None:
            stretches.append((begin, frame))
            begin = None
    return stretches
