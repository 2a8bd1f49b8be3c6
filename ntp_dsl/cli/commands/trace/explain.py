"""`ntp trace explain`: why a call was made, and what came of it."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from ntp_dsl.cli.display import answers, messages, print_json
from ntp_dsl.cli.options import Json
from ntp_dsl.cli.trace_folders import first_failed
from ntp_dsl.common.text import counted
from ntp_dsl.language.diagnostics.diagnostics import NtpError
from ntp_dsl.language.diagnostics.spelling import nearest
from ntp_dsl.semantics.observation import without_lists
from ntp_dsl.traces.explanation import explanation, interesting
from ntp_dsl.traces.overview import overview
from ntp_dsl.traces.phrases import format_call, format_invocation
from ntp_dsl.traces.reader import read_trace
from ntp_dsl.traces.schema import Call
from ntp_dsl.traces.trace import Trace

MOST = 12  # numbers of like calls that are told


def command(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="A trace, complete or cut off; or a folder.")],
    call: Annotated[
        str | None,
        typer.Argument(
            help="A call's number, its name, or the call as `ntp trace show` prints it; by default how the "
            "episode ended, and the call that one would ask about."
        ),
    ] = None,
    json: Json = False,
) -> None:
    """Say in plain words why a call was made, and what came of it.

    That is: which facts its caller saw, and which of them wrongly; which statement was due and what it
    lacked; what was read from the demonstration; and how the call ended. Without a call, it begins with
    how the episode ended: the verdict, what was called again and again, which primitives did not achieve
    what they are to, and how many decisions rest on a fact that was seen wrongly.

    Of a folder, the first trace that failed is explained.

    Example: ntp trace explain runs/episode_00000.trace.jsonl "grasp(block_3)"
    """
    trace = read_trace(first_failed(file) if file.is_dir() else file)
    chosen = _chosen(trace, call)
    paragraphs = [] if call is not None else [" ".join(overview(trace))]
    paragraphs += explanation(trace, chosen)
    if json:
        print_json({"call": chosen.id, "explanation": paragraphs})
        return
    for paragraph in paragraphs:
        answers.print(paragraph, markup=False, highlight=False)


def _chosen(trace: Trace, wanted: str | None) -> Call:
    """Return the call that is meant: of like calls the first that failed, or else the first."""
    if wanted is None:
        found = interesting(trace)
        if found is None:
            raise NtpError("the trace has no call to explain")
        return found
    if not trace.calls:
        raise NtpError("the trace has no call to explain")
    number = wanted.removeprefix("call").strip()
    if number.isdecimal():
        if len(number) > MOST or int(number) >= len(trace.calls):
            raise NtpError(f"the trace has no call {number[:MOST]}: the last one is {len(trace.calls) - 1}")
        return trace.calls[int(number)]
    wanted = _close(wanted)
    same = [each for each in trace.calls if wanted in _texts(each)]
    if not same:
        names = {each.name for each in trace.calls} | {format_call(each) for each in trace.calls}
        hint = f"; did you mean '{match}'?" if (match := nearest(wanted, names)) else ""
        raise NtpError(f"no call in the trace is '{wanted}'{hint}")
    if len(same) > 1:
        numbers = ", ".join(str(each.id) for each in same[:MOST]) + " …" * (len(same) > MOST)
        messages.print(f"{counted(len(same), 'call')} are meant: {numbers}; a number chooses one")
    return next((each for each in same if not each.succeeded), same[0])


def _texts(call: Call) -> tuple[str, ...]:
    """Return a call's name, and the call as traces and as running programs show it, without spaces."""
    as_it_runs = format_invocation(call.name, without_lists(call.arguments))
    return call.name, _close(format_call(call)), _close(as_it_runs)


def _close(text: str) -> str:
    return text.replace(" ", "")
