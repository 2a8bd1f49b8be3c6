"""`ntp trace replay`: a policy's decisions at every state of a trace."""

from __future__ import annotations

import io
from collections import Counter
from contextlib import nullcontext
from pathlib import Path
from typing import Annotated, Any

import typer

from ntp_dsl.cli.commands.trace.diff import DIFFERENT, SAME, document, report
from ntp_dsl.cli.display import answers, messages, print_json, progress
from ntp_dsl.cli.models import model_or_expert
from ntp_dsl.cli.options import Json, Model, Scripted
from ntp_dsl.cli.outputs import check_no_input
from ntp_dsl.cli.recorded_runs import heed_answers, registry_of
from ntp_dsl.cli.trace_folders import traces_in
from ntp_dsl.common.files import written_whole
from ntp_dsl.common.text import counted
from ntp_dsl.demonstrations.demonstration_files import read_demonstration
from ntp_dsl.execution.replay import Replay
from ntp_dsl.execution.replay_checks import check_replayable, check_shown
from ntp_dsl.language.diagnostics.diagnostics import NtpError
from ntp_dsl.language.registry import Registry
from ntp_dsl.policies.expert import Expert
from ntp_dsl.policies.protocol import Policy
from ntp_dsl.policies.scripted import ScriptedPolicy
from ntp_dsl.traces.comparison.comparison import Comparison
from ntp_dsl.traces.comparison.divergence import compare
from ntp_dsl.traces.comparison.teacher_forcing import count_answers
from ntp_dsl.traces.reader import parse_trace, read_trace
from ntp_dsl.traces.trace import Trace
from ntp_dsl.traces.writer import TraceWriter


def command(
    file: Annotated[
        Path, typer.Argument(metavar="TRACE", help="A trace, usually of the scripted expert; or a folder.")
    ],
    model: Model = None,
    expert: Scripted = False,
    library: Annotated[
        Path | None, typer.Option(help="The library of the trace; by default the one that it names.")
    ] = None,
    demo: Annotated[
        Path | None, typer.Option(help="The demonstration; by default the file beside the trace.")
    ] = None,
    everywhere: Annotated[bool, typer.Option("--all", help="Show every wrong answer in full.")] = False,
    out: Annotated[Path | None, typer.Option(help="Write the answers to a file, as a trace.")] = None,
    json: Json = False,
) -> int:
    """Compare a policy's decisions at every state of a trace with those of the trace.

    Each decision is judged independently of earlier errors. Of a folder, each trace has a line. Exit
    status: 0 all decisions as in the trace, 1 some differ, 2 misuse.

    Example: ntp trace replay runs/data/episode_00000.trace.jsonl
    """
    path = model_or_expert(model, expert)
    if file.is_dir():
        if demo is not None or out is not None:
            raise NtpError("--demo and --out are for one trace: omit them, or name a trace")
        return _replay_folder(traces_in(file), path, library, json)
    comparison, replayed = _compared(file, path, library, demo, out)
    count, wrong = count_answers(replayed), len(comparison.divergences)
    if json:
        print_json({"asked": count, "right": count - wrong} | document(comparison))
    else:
        kinds = Counter(str(each.kind) for each in comparison.divergences)
        counts = "".join(f", {kind} {number}" for kind, number in sorted(kinds.items()))
        answers.print(f"{count - wrong} of {count} decisions as in the trace{counts}")
        for row in report(comparison, everywhere):
            answers.print(row)
    if out is not None:
        messages.print(f"wrote {out}")
    return DIFFERENT if wrong else SAME


def _compared(
    file: Path, model: Path | None, library: Path | None, demo: Path | None = None, out: Path | None = None
) -> tuple[Comparison, Trace]:
    """Return how a policy's answers differ from a trace, and the answers."""
    trace = read_trace(file)
    registry = registry_of(trace, library, file)
    _check(registry, trace, file)
    demo = demo or _beside(trace, file)
    check_no_input(out, [file, demo])
    policy = _policy(registry, trace, model, demo)
    replayed = _replay(Replay(registry, policy, trace), model, out)
    return compare(trace, replayed), replayed


def _replay_folder(files: list[Path], model: Path | None, library: Path | None, json: bool) -> int:
    """Show for each trace how many decisions a policy would make as there."""
    rows: list[dict[str, Any]] = []
    with progress("replaying", len(files)) as bar:
        for file in files:
            comparison, replayed = _compared(file, model, library)
            count = count_answers(replayed)
            kinds = Counter(str(each.kind) for each in comparison.divergences)
            right = count - len(comparison.divergences)
            rows.append({"file": file.name, "asked": count, "right": right, "kinds": dict(kinds)})
            bar.advance()
    asked, right = (sum(row[name] for row in rows) for name in ("asked", "right"))
    if json:
        print_json({"traces": rows, "asked": asked, "right": right})
    else:
        for row in rows:
            if row["right"] < row["asked"]:
                told = "".join(f", {kind} {number}" for kind, number in sorted(row["kinds"].items()))
                answers.print(f"{row['file']}: {row['right']} of {row['asked']} decisions{told}")
        answers.print(f"{right} of {asked} decisions as in {counted(len(rows), 'trace')}")
    return DIFFERENT if right < asked else SAME


def _check(registry: Registry, trace: Trace, file: Path) -> None:
    """Raise `NtpError`, with the file, for a trace that cannot be replayed."""
    try:
        check_replayable(registry, trace)
    except NtpError as error:
        raise NtpError(f"{file}: {error}") from error


def _beside(trace: Trace, file: Path) -> Path | None:
    reference = trace.header.demonstration
    return file.parent / Path(reference.file).name if reference is not None and reference.file else None


def _policy(registry: Registry, trace: Trace, model: Path | None, demo: Path | None) -> Policy:
    if model is None:
        reference = trace.header.demonstration
        return ScriptedPolicy(Expert(registry), reference.calls if reference else None)
    from ntp_dsl.core.models import OneCoreModel, open_model

    found = open_model(model, registry, trace.header.program, trace.header.dispatch)
    if demo is None:
        was_told = trace.is_learned and trace.header.demonstration is None  # its goal, by `ntp run --goal`
        if not was_told or not isinstance(found, OneCoreModel):
            raise NtpError(
                "the trace names no demonstration, and a learned program needs one: give --demo FILE, "
                "or record the trace with --out"
            )
        policy: Policy = found.told(trace.header.understood)
    else:
        demonstration = read_demonstration(demo, trace.header.objects)
        check_shown(trace, demonstration)
        policy = found.shown(demonstration)
    heed_answers(trace, policy)
    return policy


def _replay(replay: Replay, model: Path | None, out: Path | None) -> Trace:
    stream = io.StringIO()
    replay.write(TraceWriter(stream), str(model) if model else None)
    text = stream.getvalue()
    with written_whole(out) if out else nullcontext() as partial:
        if partial is not None:
            partial.write_text(text, encoding="utf-8")
    return parse_trace(text.encode(), out or Path("the replay"))
