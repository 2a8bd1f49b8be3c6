"""`ntp trace show`: the call tree of a trace in the terminal."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import groupby
from pathlib import Path
from typing import Annotated

import typer
from rich.text import Text

from ntp_dsl.cli.calls import as_json, demonstration_frames, line
from ntp_dsl.cli.display import answers, print_json
from ntp_dsl.cli.options import Json
from ntp_dsl.cli.trace_folders import summary, traces_in
from ntp_dsl.common.text import counted, printable
from ntp_dsl.language.diagnostics.diagnostics import NtpError
from ntp_dsl.language.diagnostics.spelling import nearest
from ntp_dsl.traces.explanation import brief
from ntp_dsl.traces.phrases import format_asked, format_call, format_doubt, headline
from ntp_dsl.traces.reader import read_trace
from ntp_dsl.traces.schema import ROOT, Call, Ending
from ntp_dsl.traces.times import Times, inclusive_times
from ntp_dsl.traces.trace import Trace

LINES = 160  # beyond which successful calls are folded
UNSURE = 0.5  # probability below which a decision is not folded
INDENTED = 40  # levels; deeper ones are not indented further


def command(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="A trace, complete or cut off; or a folder.")],
    depth: Annotated[int | None, typer.Option(min=1, help="Number of levels to show.")] = None,
    failed: Annotated[
        bool, typer.Option("--failed", help="Show only failed calls and their callers.")
    ] = False,
    only: Annotated[
        str | None, typer.Option(help="Show only calls of this program or primitive, and their callers.")
    ] = None,
    everything: Annotated[
        bool, typer.Option("--all", help="Show all calls, however long the trace is.")
    ] = False,
    why: Annotated[
        bool,
        typer.Option(
            "--why",
            help="Add to each call its number, which facts did not hold, and which were seen wrongly.",
        ),
    ] = False,
    json: Json = False,
) -> None:
    """Show the call tree of a trace, with arguments, scopes, outcomes, probabilities and times.

    Long traces are folded: failed and uncertain calls are shown, and as many levels as fit on a few pages.

    Of a folder, its traces are listed.

    Example: ntp trace show runs/episode_00000.trace.jsonl --depth 2
    """
    if file.is_dir():
        _show_folder(file, json)
        return
    trace = read_trace(file)
    times = inclusive_times(trace)
    chosen = _chosen(trace, failed, only)
    if depth is not None:
        chosen &= _levels(trace, depth)
    elif not everything and not failed and only is None:
        chosen = _folded(trace, chosen)
    if json:
        rows = [as_json(trace.calls[number], times[number]) for number in sorted(chosen)]
        print_json({"header": trace.header, "calls": rows, "end": trace.end})
        return
    answers.print(Text(headline(trace.header), style="bold"))
    for sentence in trace.header.said:
        answers.print(Text(f'said: "{printable(sentence)}"', style="cyan"))
    narrowed = failed or only is not None
    for row in _lines(trace, times, chosen, narrowed, why):
        answers.print(row, no_wrap=True, overflow="ellipsis", crop=answers.is_terminal)
    for call, reading in trace.readings():
        for doubt in reading.doubts:
            answers.print(Text(f"{call.name} read {format_doubt(doubt)}", style="yellow"))
    for call, _, asked in trace.questions():
        answers.print(Text(f"{format_call(call)} might {format_asked(asked)}", style="yellow"))
    answers.print(_ending(trace))


def _show_folder(folder: Path, json: bool) -> None:
    """List the traces of a folder: how many calls each has, and how it ended."""
    rows = [summary(file) for file in traces_in(folder)]
    if json:
        print_json(rows)
        return
    for row in rows:
        cause = f" ({row.attributed_to})" if row.attributed_to else ""
        failed = f"; failed{cause}: {row.verdict}" if row.success is False else ""
        text = printable(f"{row.file}  {counted(row.calls, 'call')}  {row.ending}{failed}")
        answers.print(Text(text, style="red" if failed else ""))


# Which calls are shown ---------------------------------------------------------------------------


def _chosen(trace: Trace, failed: bool, only: str | None) -> set[int]:
    calls = trace.calls
    if failed:
        calls = [call for call in calls if not call.succeeded]
    if only is not None:
        names = {call.name for call in trace.calls}
        if only not in names:
            hint = f"; did you mean '{match}'?" if (match := nearest(only, names)) else ""
            raise NtpError(
                f"no call in the trace is named '{only}'{hint} (available: {', '.join(sorted(names))})"
            )
        calls = [call for call in calls if call.name == only]
    return _with_callers(trace, calls)


def _with_callers(trace: Trace, calls: list[Call]) -> set[int]:
    kept: set[int] = set()
    for call in calls:
        for each in trace.ancestors(call.id):
            if each.id in kept:
                break
            kept.add(each.id)
    return kept


def _depths(trace: Trace) -> list[int]:
    depths: list[int] = []
    for call in trace.calls:
        depths.append(0 if call.parent == ROOT else depths[call.parent] + 1)
    return depths


def _levels(trace: Trace, depth: int) -> set[int]:
    return {number for number, level in enumerate(_depths(trace)) if level < depth}


def _folded(trace: Trace, chosen: set[int]) -> set[int]:
    """Return the failed and uncertain calls, and of the others the upper levels, as many as fit."""
    if len(chosen) <= LINES:
        return chosen
    uncertain = [c for c in trace.calls if not c.succeeded or (c.decision.probability or 1.0) < UNSURE]
    kept = _with_callers(trace, uncertain)
    if len(kept) > LINES:
        kept = set()
    depths = _depths(trace)
    for number in sorted(chosen, key=lambda number: (depths[number], number)):
        if len(kept) >= LINES:
            break
        kept.add(number)
    return kept


# How they are shown ------------------------------------------------------------------------------


def _lines(trace: Trace, times: list[Times], chosen: set[int], narrowed: bool, why: bool) -> Iterator[Text]:
    """Yield the lines of the tree, without recursion: traces may be deeper than Python's stack."""
    frames = demonstration_frames(trace)
    waiting = [(each, "") for each in reversed(_siblings(trace, ROOT, chosen, narrowed))]
    while waiting:
        (group, hidden, is_last), stem = waiting.pop()
        row = Text(f"{stem}{'└── ' if is_last else '├── '}", style="not bold")
        if not group:
            yield row.append(f"... {hidden} call{'s' * (hidden != 1)}", style="dim")
            continue
        call = group[0]
        row.append_text(line(call, frames, times[call.id]))
        if len(group) > 1:
            row.append(f"  ×{len(group)}", style="dim not bold")
        if why:
            told = brief(call)
            row.append(f"  call {call.id}{': ' * bool(told)}{told}", style="cyan not bold")
        yield row
        below = stem + ("    " if is_last else "│   ") if len(stem) < 4 * INDENTED else stem
        siblings = _siblings(trace, call.id, chosen, narrowed)
        waiting += [(each, below) for each in reversed(siblings)]


Siblings = tuple[list[Call], int, bool]  # equal consecutive calls, or how many are folded; whether last


def _siblings(trace: Trace, parent: int, chosen: set[int], narrowed: bool) -> list[Siblings]:
    children = trace.children(parent)
    present = [call for call in children if call.id in chosen]
    groups = [list(group) for _, group in groupby(present, lambda call: _group_key(trace, call))]
    found: list[tuple[list[Call], int]] = [(group, 0) for group in groups]
    if not narrowed and len(present) < len(children):
        found.append(([], len(children) - len(present)))
    return [(group, hidden, n == len(found) - 1) for n, (group, hidden) in enumerate(found)]


def _group_key(trace: Trace, call: Call) -> object:
    """Return a key that is equal for calls that are shown as one line: leaves that repeat."""
    if trace.children(call.id):
        return call.id
    return format_call(call), call.scope, call.outcome, call.execution.disturbances


def _ending(trace: Trace) -> Text:
    end = trace.end
    if end is None:
        return Text("cut off: the trace ends here", style="yellow")
    succeeded = end.ending is Ending.DONE if end.success is None else end.success
    reason = f": {end.reason}" if end.reason and not end.verdict else ""  # a verdict says it as well
    cause = f" ({end.attributed_to})" if end.attributed_to else ""
    failed = f"; failed{cause}: {end.verdict}" if end.verdict else ""
    sure = f", confidence {end.confidence:.0%}" if end.confidence is not None else ""
    text = printable(f"{end.ending}{reason} ({counted(end.primitives, 'primitive')}{sure}){failed}")
    return Text(text, style="green" if succeeded else "red")
