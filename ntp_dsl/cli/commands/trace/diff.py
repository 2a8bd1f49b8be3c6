"""`ntp trace diff`: where two traces part, and what that is attributed to."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from math import isfinite
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.text import Text

from ntp_dsl.cli.display import answers, print_json
from ntp_dsl.cli.options import Json
from ntp_dsl.traces.comparison.comparison import Comparison, Divergence
from ntp_dsl.traces.comparison.comparison_rules import DivergenceKind
from ntp_dsl.traces.comparison.divergence import compare
from ntp_dsl.traces.decision import Answer
from ntp_dsl.traces.phrases import format_call, format_invocation, format_scope, headline, printable
from ntp_dsl.traces.reader import read_trace
from ntp_dsl.traces.schema import Call, Trace
from ntp_dsl.traces.sources import statement

SAME, DIFFERENT = 0, 1
SHOWN = 20  # divergences that --all shows in full; of more, the first


def command(
    first: Annotated[Path, typer.Argument(metavar="A", help="The trace that is right: the script's.")],
    second: Annotated[Path, typer.Argument(metavar="B", help="The trace that is compared with it.")],
    everywhere: Annotated[bool, typer.Option("--all", help="Every divergence, not the first alone.")] = False,
    no_scopes: Annotated[
        bool, typer.Option("--no-scopes", help="Compare what was done, not the scopes it was given.")
    ] = False,
    json: Json = False,
) -> int:
    """Show where the second trace first leaves the first, how surely, and why.

    Kinds: program, argument, scope, end too early, end too late, outcome. A divergence is attributed to the
    decision where the two states were alike, else to what had made them differ. Exit status: 0 the same,
    1 they differ, 2 misuse.

    Example: ntp trace diff scripted.trace.jsonl learned.trace.jsonl
    """
    comparison = compare(read_trace(first), read_trace(second), scopes=not no_scopes)
    if json:
        print_json(document(comparison))
    else:
        answers.print(Text(f"A {first}: {headline(comparison.a)}", style="bold"))
        answers.print(Text(f"B {second}: {headline(comparison.b)}", style="bold"))
        for row in report(comparison, everywhere):
            answers.print(row)
    return DIFFERENT if comparison.first else SAME


# In words ----------------------------------------------------------------------------------------


def report(comparison: Comparison, everywhere: bool) -> Iterator[Text]:
    """The first divergence, or many of them, for people."""
    yield from _warnings(comparison)
    if comparison.first is None:
        yield Text(f"the same: {len(comparison.a.calls)} calls", style="green")
        return
    told = comparison.divergences[: SHOWN if everywhere else 1]
    for number, divergence in enumerate(told):
        yield from _paragraph(comparison, divergence, "first divergence" if not number else "then")
    rest = Counter(str(each.kind) for each in comparison.divergences[len(told) :])
    if rest:
        counted = ", ".join(f"{kind} {count}" for kind, count in sorted(rest.items()))
        hint = "" if everywhere else "  (--all shows them)"
        yield Text(f"{rest.total()} more: {counted}{hint}", style="dim")


def _warnings(comparison: Comparison) -> Iterator[Text]:
    """What the headers say that makes a comparison mean less."""
    a, b = comparison.a.header, comparison.b.header
    for name, x, y in (("library", a.library, b.library), ("task", a.task, b.task), ("goal", a.goal, b.goal)):
        if x != y:
            yield Text(f"not of one {name}: the traces are of different tasks", style="yellow")
            return
    if a.registry != b.registry:
        yield Text("the library was changed between the two traces", style="yellow")


def _paragraph(comparison: Comparison, found: Divergence, title: str) -> Iterator[Text]:
    kind = Text(f"{title}: ", style="bold").append(str(found.kind), style="red")
    yield kind.append(
        f", attributed to {found.attributed_to}" if found.attributed_to else "", style="default not bold"
    )
    path = [format_call(call) for call in reversed(list(comparison.a.ancestors(found.caller_a)))]
    yield Text(f"  in  {' > '.join(path) or 'the run'}")
    yield Text("  A   " + _did(comparison.a, found, found.a)).append(_where(comparison, found), "dim")
    yield Text("  B   " + (_did(comparison.b, found, found.b) if found.answer is None else _would(found)))
    if sure := _confidence(found):
        yield Text(f"      {sure}", style="dim")
    if found.state_distance is not None:
        yield Text(f"      {_states(found.state_distance)}", style="dim")
    a, b = followed(comparison, found)
    if a or b:
        yield Text(f"      what followed is folded away: {a} calls of A, {b} of B", style="dim")


def _would(found: Divergence) -> str:
    """What a policy answered that was only asked."""
    answer = found.answer
    assert answer is not None
    if answer.callee is None:
        return "would return"
    scope = f"  {format_scope(answer.scope)}" if found.kind is DivergenceKind.SCOPE else ""
    return f"would call {format_invocation(answer.callee, answer.arguments)}{scope}"


def _did(trace: Trace, found: Divergence, number: int | None) -> str:
    if number is None:
        return "ends here" if found.kind is DivergenceKind.CUT_OFF else "returns"
    call = trace.calls[number]
    words = format_call(call)
    if found.kind is DivergenceKind.OUTCOME or found.kind is DivergenceKind.CUT_OFF:
        return f"{words}  {call.outcome or 'cut off'}{_told(call)}"
    if found.kind is DivergenceKind.SCOPE:
        return f"{words}  {format_scope(call.scope)}"
    return words


def _told(call: Call) -> str:
    return "".join(f"  [{printable(each)}]" for each in call.execution.disturbances)


def _where(comparison: Comparison, found: Divergence) -> str:
    text = statement(comparison.a, found.source)
    return f"   {printable(found.source)}{f':  {printable(text)}' if text else ''}" if found.source else ""


def _confidence(found: Divergence) -> str:
    sure = found.confidence
    if sure.chosen is None:
        return ""
    right = (
        f"the right one is number {sure.rank} (p={sure.right:.2f})"
        if sure.rank
        else ("the right one is not among the likely ones")
    )
    return f"p={sure.chosen:.2f}; {right}; margin {sure.margin:.2f}"


def _states(apart: float) -> str:
    if not isfinite(apart):
        return "the states differ: an object is lost, or the hand is open in one and closed in the other"
    return f"the states lie {1000 * apart:.1f} mm apart"


def followed(comparison: Comparison, found: Divergence) -> tuple[int, int]:
    """How many calls either trace made after the moment; none where they went on alike."""
    if found.kind in (DivergenceKind.SCOPE, DivergenceKind.OUTCOME) or found.answer is not None:
        return 0, 0
    begin_a = _next(comparison.a, found.a, found.caller_a)
    begin_b = _next(comparison.b, found.b, found.caller_b)
    return len(comparison.a.calls) - begin_a, len(comparison.b.calls) - begin_b


def _next(trace: Trace, call: int | None, caller: int) -> int:
    """The number of the first call from a moment on."""
    if call is not None:
        return call
    inside = {caller}
    for each in trace.calls[caller + 1 :]:
        if each.parent not in inside:
            return each.id
        inside.add(each.id)
    return len(trace.calls)


# For machines ------------------------------------------------------------------------------------


def document(comparison: Comparison) -> dict[str, Any]:
    rows = [as_json(comparison, each) for each in comparison.divergences]
    return {
        "differ": bool(rows),
        "first": rows[0] if rows else None,
        "divergences": rows,
        "counts": dict(Counter(row["kind"] for row in rows)),
        "calls": {"a": len(comparison.a.calls), "b": len(comparison.b.calls)},
        "matched": sum(None not in pair for level in comparison.levels for pair in level.pairs),
    }


def as_json(comparison: Comparison, found: Divergence) -> dict[str, Any]:
    apart = found.state_distance
    return {
        "kind": str(found.kind),
        "attributed_to": found.attributed_to or "",
        "path": [call.name for call in reversed(list(comparison.a.ancestors(found.caller_a)))],
        "a": _call(comparison.a, found.a),
        "b": _call(comparison.b, found.b) if found.answer is None else _answer(found.answer),
        "source": found.source,
        "statement": statement(comparison.a, found.source),
        "probability": found.confidence.chosen,
        "right_probability": found.confidence.right,
        "right_rank": found.confidence.rank,
        "margin": found.confidence.margin,
        "state_distance": apart if apart is None or isfinite(apart) else None,
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
