"""`ntp trace replay`: a policy asked at every state of a trace."""

from __future__ import annotations

import io
from collections import Counter
from contextlib import nullcontext
from pathlib import Path
from typing import Annotated

import typer

from ntp_dsl.cli.commands.trace.diff import DIFFERENT, SAME, document, report
from ntp_dsl.cli.display import answers, messages, print_json
from ntp_dsl.cli.models import model_for
from ntp_dsl.cli.options import Json, Model, Scripted
from ntp_dsl.common.files import written_whole
from ntp_dsl.demonstrations.demonstration_files import read_demonstration
from ntp_dsl.execution.replay import Replay
from ntp_dsl.language.diagnostics.diagnostics import NtpError
from ntp_dsl.language.registry import Registry
from ntp_dsl.policies.expert import Expert
from ntp_dsl.policies.protocol import Policy
from ntp_dsl.policies.scripted import ScriptedPolicy
from ntp_dsl.traces.comparison.divergence import compare
from ntp_dsl.traces.comparison.teacher_forcing import count_answers
from ntp_dsl.traces.reader import parse_trace, read_trace
from ntp_dsl.traces.schema import Trace
from ntp_dsl.traces.writer import TraceWriter
from ntp_dsl.user_code.loading import load_with_python


def command(
    file: Annotated[Path, typer.Argument(metavar="TRACE", help="A trace, of a script most often.")],
    model: Model = None,
    expert: Scripted = False,
    library: Annotated[
        Path | None, typer.Option(help="The trace's library; by default what it names, of the examples.")
    ] = None,
    demo: Annotated[
        Path | None, typer.Option(help="Its demonstration; by default the one that lies beside it.")
    ] = None,
    everywhere: Annotated[bool, typer.Option("--all", help="Every wrong answer in full.")] = False,
    out: Annotated[Path | None, typer.Option(help="A file for the answers, as a trace.")] = None,
    json: Json = False,
) -> int:
    """Ask a policy at every state of a trace, and compare its answers with what was done there.

    So each decision is judged by itself, whatever went wrong before. Exit status: 0 all as in the trace,
    1 some not, 2 misuse.

    Example: ntp trace replay runs/data/episode_00000.trace.jsonl
    """
    trace = read_trace(file)
    registry = _registry(trace, library, file)
    if expert and model is not None:
        raise NtpError("--expert needs no --model: the script answers")
    path = None if expert else model_for(library or registry_path(trace), trace.header.task, model)
    policy = _policy(registry, trace, path, demo or _beside(trace, file))
    replayed = _written(Replay(registry, policy, trace), path, out)
    comparison = compare(trace, replayed)
    count, wrong = count_answers(replayed), len(comparison.divergences)
    if json:
        print_json({"asked": count, "right": count - wrong} | document(comparison))
    else:
        kinds = Counter(str(each.kind) for each in comparison.divergences)
        told = "".join(f", {kind} {number}" for kind, number in sorted(kinds.items()))
        answers.print(f"{count - wrong} of {count} decisions as in the trace{told}")
        for row in report(comparison, everywhere):
            answers.print(row)
    if out is not None:
        messages.print(f"wrote {out}")
    return DIFFERENT if wrong else SAME


def registry_path(trace: Trace) -> Path:
    return Path(trace.header.library)


def _registry(trace: Trace, library: Path | None, file: Path) -> Registry:
    for field, value in (("library", trace.header.library), ("task", trace.header.task)):
        if not value:
            raise NtpError(f"{file}: the trace does not say of which {field} it is; it cannot be replayed")
    try:
        registry = load_with_python(library or registry_path(trace))
    except NtpError as error:
        hint = "" if library else "; say where the library is with --library"
        raise NtpError(f"{error}{hint}") from error
    if registry.hash != trace.header.registry:
        raise NtpError(
            f"{file}: was made with another version of library '{trace.header.library}' "
            f"({trace.header.registry}); expected {registry.hash}"
        )
    return registry


def _beside(trace: Trace, file: Path) -> Path | None:
    shown = trace.header.demonstration
    return file.parent / Path(shown.file).name if shown is not None and shown.file else None


def _policy(registry: Registry, trace: Trace, model: Path | None, demo: Path | None) -> Policy:
    if model is None:
        shown = trace.header.demonstration
        return ScriptedPolicy(Expert(registry), shown.calls if shown else None)
    if demo is None:
        raise NtpError(
            "the trace names no demonstration, and a learned program needs one: say --demo FILE, "
            "or make the trace with --out"
        )
    from ntp_dsl.core.checkpoint import load_core
    from ntp_dsl.core.policy import LearnedPolicy

    return LearnedPolicy(load_core(model).core, read_demonstration(demo))


def _written(replay: Replay, model: Path | None, out: Path | None) -> Trace:
    stream = io.StringIO()
    replay.write(TraceWriter(stream), str(model) if model else None)
    text = stream.getvalue()
    with written_whole(out) if out else nullcontext() as partial:
        if partial is not None:
            partial.write_text(text, encoding="utf-8")
    return parse_trace(text.encode(), out or Path("the replay"))
