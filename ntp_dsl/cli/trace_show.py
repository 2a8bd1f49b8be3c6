"""`ntp trace show`: the call tree of a trace in the terminal."""

from __future__ import annotations

from collections import defaultdict
from pathlib import Path
from typing import Annotated

import typer
from rich.text import Text
from rich.tree import Tree

from ntp_dsl.cli.display import answers
from ntp_dsl.traces import ROOT, Call, Trace, read_trace
from ntp_dsl.world import Argument, Record

BAR = 12  # characters for the whole demonstration
BRIEF = 3  # elements of a list that are shown
WELL = {"done": "green", "achieved": "green", "unfinished": "yellow"}
Children = dict[int, list[Call]]


def command(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="A trace, whole or cut off.")],
    depth: Annotated[int | None, typer.Option(min=1, help="Show so many levels of calls.")] = None,
    failed: Annotated[
        bool, typer.Option("--failed", help="Only what failed, and what it was called by.")
    ] = False,
) -> None:
    """Show who called what, over which part of the demonstration, how surely, and what came of it.

    Example: ntp trace show runs/episode_00000.trace.jsonl --depth 2
    """
    trace = read_trace(file)
    children: Children = defaultdict(list)
    for call in trace.calls:
        children[call.parent].append(call)
    tree = Tree(_headline(trace))
    _grow(tree, ROOT, children, _frames(trace), depth, _failures(trace) if failed else None)
    answers.print(tree)
    answers.print(_ending(trace))


def _grow(
    tree: Tree,
    parent: int,
    children: Children,
    frames: int,
    depth: int | None,
    only: set[int] | None,
) -> None:
    for call in children[parent]:
        if only is not None and call.id not in only:
            continue
        branch = tree.add(_line(call, frames))
        if depth != 1:
            _grow(branch, call.id, children, frames, depth and depth - 1, only)
        elif below := len(children[call.id]):
            branch.add(Text(f"... {below} call{'s' * (below != 1)}", style="dim"))


def _headline(trace: Trace) -> Text:
    told = ("library", "task", "policy", "seed")
    facts = [f"{name} {trace.header[name]}" for name in told if name in trace.header]
    return Text(", ".join(facts) or "a trace", style="bold")


def _ending(trace: Trace) -> Text:
    if trace.end is None:
        return Text("cut off: the trace ends here", style="yellow")
    done = bool(trace.end.get("done"))
    counted = f" ({trace.end['primitives']} primitives)" if "primitives" in trace.end else ""
    return Text(f"{trace.end.get('reason', '')}{counted}", style="green" if done else "red")


def _line(call: Call, frames: int) -> Text:
    line = Text(call.name, style="bold" if call.kind == "program" else "cyan")
    line.append(f"({', '.join(shown(each) for each in call.arguments)})", style="default not bold")
    line.append(f"  {scope_bar(call, frames)}  ", style="blue not bold")
    outcome = call.outcome or "cut off"
    line.append(outcome, style=f"{WELL.get(outcome, 'red')} not bold")
    certainty = call.decision.get("probability")
    if isinstance(certainty, float):
        line.append(f"  p={certainty:.2f}", style="dim not bold")
    for disturbance in call.details.get("disturbances", ()):
        line.append(f"  [{disturbance}]", style="magenta not bold")
    return line


def shown(argument: Argument) -> str:
    """An argument, briefly: records without their types."""
    if isinstance(argument, Record):
        return f"({', '.join(value for _, value in argument.fields)})"
    if isinstance(argument, tuple):
        more = [f"... {len(argument) - BRIEF} more"] if len(argument) > BRIEF else []
        return f"[{', '.join([*(shown(each) for each in argument[:BRIEF]), *more])}]"
    return str(argument)


def scope_bar(call: Call, frames: int) -> str:
    """The part of the demonstration that a call was given; dots where it was given none."""
    if call.scope is None:
        return "·" * BAR
    begin, end = (round(BAR * frame / frames) for frame in call.scope)
    begin = min(begin, BAR - 1)
    end = min(max(end, begin + 1), BAR)
    return "─" * begin + "█" * (end - begin) + "─" * (BAR - end)


def _frames(trace: Trace) -> int:
    """How long the demonstration is, as far as the trace says."""
    return max([1, *(call.scope[1] for call in trace.calls if call.scope)])


def _failures(trace: Trace) -> set[int]:
    """The calls that did not do what they should, and all above them."""
    parents = {call.id: call.parent for call in trace.calls}
    kept: set[int] = set()
    for call in trace.calls:
        number = call.id
        while call.outcome not in ("done", "achieved") and number in parents and number not in kept:
            kept.add(number)
            number = parents[number]
    return kept
