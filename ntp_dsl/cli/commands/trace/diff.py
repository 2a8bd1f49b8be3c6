"""`ntp trace diff`: where two traces diverge, and what it is attributed to."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from math import isfinite
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.text import Text

from ntp_dsl.cli.display import answers, print_json, progress
from ntp_dsl.cli.options import Json
from ntp_dsl.cli.trace_folders import pairs
from ntp_dsl.common.text import counted, printable
from ntp_dsl.traces.comparison.comparison import Comparison, Divergence
from ntp_dsl.traces.comparison.comparison_rules import DivergenceKind
from ntp_dsl.traces.comparison.divergence import compare
from ntp_dsl.traces.decision import Answer
from ntp_dsl.traces.explanation import brief
from ntp_dsl.traces.phrases import format_call, format_invocation, format_scope, headline
from ntp_dsl.traces.reader import read_trace
from ntp_dsl.traces.schema import Call
from ntp_dsl.traces.sources import statement
from ntp_dsl.traces.trace import Trace

SAME, DIFFERENT = 0, 1
MAX_SHOWN = 20  # most divergences that --all shows in full


def command(
    first: Annotated[
        Path, typer.Argument(metavar="A", help="The reference trace: the expert's; or a folder of such.")
    ],
    second: Annotated[
        Path, typer.Argument(metavar="B", help="The trace to compare with it, or a folder: by equal names.")
    ],
    everywhere: Annotated[
        bool, typer.Option("--all", help="Show all divergences, not only the first.")
    ] = False,
    no_scopes: Annotated[bool, typer.Option("--no-scopes", help="Ignore the scopes of calls.")] = False,
    json: Json = False,
) -> int:
    """Show where the second trace first diverges from the first, its confidence, and the cause.

    Kinds: program, argument, scope, end too early, end too late, outcome. A divergence is attributed to the
    decision where the two states were the same, else to what made them differ. Of two folders, each pair
    of traces has a line. Exit status: 0 the same, 1 different, 2 misuse.

    Example: ntp trace diff scripted.trace.jsonl learned.trace.jsonl
    """
    if first.is_dir() or second.is_dir():
        return _diff_folders(pairs(first, second), not no_scopes, json)
    comparison = compare(read_trace(first), read_trace(second), scopes=not no_scopes)
    if json:
        print_json(document(comparison))
    else:
        answers.print(Text(f"A {first}: {headline(comparison.a.header)}", style="bold"))
        answers.print(Text(f"B {second}: {headline(comparison.b.header)}", style="bold"))
        for row in report(comparison, everywhere):
            answers.print(row)
    return SAME if comparison.is_same else DIFFERENT


def _diff_folders(files: list[tuple[Path, Path]], scopes: bool, json: bool) -> int:
    """Show a line for each pair of traces, and which first divergences there are."""
    rows: list[dict[str, Any]] = []
    with progress("comparing", len(files)) as bar:
        for a, b in files:
            comparison = compare(read_trace(a), read_trace(b), scopes=scopes)
            first = as_json(comparison, comparison.first) if comparison.first else None
            row = {"file": a.name, "first": first, "divergences": len(comparison.divergences)}
            rows.append(row | {"verdicts": comparison.verdicts})
            bar.advance()
    found = [(row, row["first"]) for row in rows if row["first"] is not None]
    judged = [row for row in rows if row["first"] is None and row["verdicts"]]
    same = len(rows) - len(found) - len(judged)
    if json:
        print_json({"pairs": rows, "same": same})
        return DIFFERENT if same < len(rows) else SAME
    for row, first in found:
        cause = f", attributed to {first['attributed_to']}" if first["attributed_to"] else ""
        where = f" at {printable(first['source'])}" if first["source"] else ""
        answers.print(Text(f"{row['file']}: {first['kind']}{where}{cause}", style="red"))
    for row in judged:
        answers.print(Text(f"{row['file']}: the same calls, and {row['verdicts']}", style="red"))
    answers.print(f"{same} of {counted(len(rows), 'pair')} the same")
    places = Counter((str(first["kind"]), str(first["source"])) for _, first in found)
    for (kind, place), count in places.most_common():
        answers.print(f"  {count} × {kind}{f' at {printable(place)}' if place else ''}")
    return DIFFERENT if same < len(rows) else SAME


# As text ----------------------------------------------------------------------------------------


def report(comparison: Comparison, everywhere: bool) -> Iterator[Text]:
    """Yield the first divergence, or many of them, as lines of text."""
    yield from _warnings(comparison)
    if comparison.first is None:
        yield Text(f"the same: {len(comparison.a.calls)} calls", style="green")
        if comparison.verdicts:
            text = f"and yet judged otherwise: {comparison.verdicts}"
            yield Text(text, style="red")
        return
    listed = comparison.divergences[: MAX_SHOWN if everywhere else 1]
    for number, divergence in enumerate(listed):
        yield from _paragraph(comparison, divergence, "first divergence" if not number else "then")
    rest = Counter(str(each.kind) for each in comparison.divergences[len(listed) :])
    if rest:
        kinds = ", ".join(f"{kind} {count}" for kind, count in sorted(rest.items()))
        hint = "" if everywhere else "  (--all shows them)"
        yield Text(f"{rest.total()} more: {kinds}{hint}", style="dim")


def _warnings(comparison: Comparison) -> Iterator[Text]:
    """Yield warnings where the headers show that the traces are not comparable."""
    a, b = comparison.a.header, comparison.b.header
    for name, x, y in (("library", a.library, b.library), ("task", a.task, b.task), ("goal", a.goal, b.goal)):
        if x != y:
            yield Text(f"different {name}: the traces are not of the same task", style="yellow")
            return
    if a.registry != b.registry:
        yield Text("the library changed between the two traces", style="yellow")


def _paragraph(comparison: Comparison, divergence: Divergence, title: str) -> Iterator[Text]:
    kind = Text(f"{title}: ", style="bold").append(str(divergence.kind), style="red")
    yield kind.append(
        f", attributed to {divergence.attributed_to}" if divergence.attributed_to else "",
        style="default not bold",
    )
    path = [format_call(call) for call in reversed(list(comparison.a.ancestors(divergence.caller_a)))]
    yield Text(f"  in  {' > '.join(path) or 'the run'}")
    action_a = _action(comparison.a, divergence, divergence.a)
    is_answer = divergence.answer is not None
    action_b = _answered_action(divergence) if is_answer else _action(comparison.b, divergence, divergence.b)
    yield Text(f"  A   {action_a}").append(_where(comparison, divergence), "dim")
    yield Text(f"  B   {action_b}")
    if confidence := _confidence(divergence):
        yield Text(f"      {confidence}", style="dim")
    if apart := str(divergence.states or ""):
        yield Text(f"      the states differ: {apart}", style="dim")
    decides = divergence.kind is not DivergenceKind.OUTCOME
    if decides and divergence.b is not None and (why := brief(comparison.b.calls[divergence.b])):
        yield Text(f"      B's reasons: {why}", style="dim")
    a, b = followed(comparison, divergence)
    if a or b:
        yield Text(f"      not shown: the {a} following calls of A, {b} of B", style="dim")


def _answered_action(divergence: Divergence) -> str:
    """Return the answer of a replayed policy as text."""
    answer = divergence.answer
    assert answer is not None
    if answer.callee is None:
        return "would return"
    scope = f"  {format_scope(answer.scope)}" if divergence.kind is DivergenceKind.SCOPE else ""
    return f"would call {format_invocation(answer.callee, answer.arguments)}{scope}"


def _action(trace: Trace, divergence: Divergence, number: int | None) -> str:
    if number is None:
        return "ends here" if divergence.kind is DivergenceKind.CUT_OFF else "returns"
    call = trace.calls[number]
    words = format_call(call)
    if divergence.kind is DivergenceKind.OUTCOME or divergence.kind is DivergenceKind.CUT_OFF:
        return f"{words}  {call.outcome or 'cut off'}{_told(call)}"
    if divergence.kind is DivergenceKind.SCOPE:
        return f"{words}  {format_scope(call.scope)}"
    return words


def _told(call: Call) -> str:
    return "".join(f"  [{printable(each)}]" for each in call.execution.disturbances)


def _where(comparison: Comparison, divergence: Divergence) -> str:
    if not divergence.source:
        return ""
    text = statement(comparison.a, divergence.source)
    return f"   {printable(divergence.source)}{f':  {printable(text)}' if text else ''}"


def _confidence(divergence: Divergence) -> str:
    confidence = divergence.confidence
    if confidence.chosen is None:
        return ""
    right = (
        f"the right one has rank {confidence.rank} (p={confidence.right:.2f})"
        if confidence.rank
        else "the right one is not among the alternatives"
    )
    return f"p={confidence.chosen:.2f}; {right}; margin {confidence.margin:.2f}"


def followed(comparison: Comparison, divergence: Divergence) -> tuple[int, int]:
    """Return how many calls each trace made after a divergence; 0 where the traces continue in parallel."""
    if divergence.kind in (DivergenceKind.SCOPE, DivergenceKind.OUTCOME) or divergence.answer is not None:
        return 0, 0
    begin_a = _next(comparison.a, divergence.a, divergence.caller_a)
    begin_b = _next(comparison.b, divergence.b, divergence.caller_b)
    return len(comparison.a.calls) - begin_a, len(comparison.b.calls) - begin_b


def _next(trace: Trace, call: int | None, caller: int) -> int:
    """Return the number of the divergent call, or of the first one after the caller's return."""
    if call is not None:
        return call
    inside = {caller}
    for each in trace.calls[caller + 1 :]:
        if each.parent not in inside:
            return each.id
        inside.add(each.id)
    return len(trace.calls)


# As JSON -----------------------------------------------------------------------------------------


def document(comparison: Comparison) -> dict[str, Any]:
    """Return a comparison as a JSON document."""
    rows = [as_json(comparison, each) for each in comparison.divergences]
    return {
        "differ": not comparison.is_same,
        "verdicts": comparison.verdicts,
        "first": rows[0] if rows else None,
        "divergences": rows,
        "counts": dict(Counter(row["kind"] for row in rows)),
        "calls": {"a": len(comparison.a.calls), "b": len(comparison.b.calls)},
        "matched": sum(None not in pair for level in comparison.levels for pair in level.pairs),
    }


def as_json(comparison: Comparison, divergence: Divergence) -> dict[str, Any]:
    """Return a divergence as a row of JSON."""
    distance = None if divergence.states is None else divergence.states.largest
    return {
        "kind": str(divergence.kind),
        "attributed_to": divergence.attributed_to or "",
        "path": [call.name for call in reversed(list(comparison.a.ancestors(divergence.caller_a)))],
        "a": _call(comparison.a, divergence.a),
        "b": _call(comparison.b, divergence.b) if divergence.answer is None else _answer(divergence.answer),
        "source": divergence.source,
        "statement": statement(comparison.a, divergence.source),
        "probability": divergence.confidence.chosen,
        "right_probability": divergence.confidence.right,
        "right_rank": divergence.confidence.rank,
        "margin": divergence.confidence.margin,
        "state_distance": distance if distance is None or isfinite(distance) else None,
    }


def _answer(answer: Answer) -> dict[str, Any] | None:
    if answer.callee is None:
        return None
    return {"name": answer.callee, "arguments": answer.arguments, "scope": answer.scope}


def _call(trace: Trace, number: int | None) -> dict[str, Any] | None:
    if number is None:
        return None
    call = trace.calls[number]
    row = {"id": number, "name": call.name, "arguments": call.arguments, "scope": call.scope}
    return row | {"outcome": call.outcome or "", "disturbances": call.execution.disturbances}
