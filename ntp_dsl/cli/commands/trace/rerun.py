"""`ntp trace rerun`: the run of a trace once more, to step it, or to its end where it was cut off."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from ntp_dsl.cli.commands.trace.diff import DIFFERENT, SAME, as_json, report
from ntp_dsl.cli.display import answers, messages, print_json
from ntp_dsl.cli.live_runs.call_tree import LiveTree
from ntp_dsl.cli.live_runs.stepping import supervised
from ntp_dsl.cli.options import BreakAt, Inject, Json, Step, Viewer, Watch
from ntp_dsl.cli.outputs import check_no_input
from ntp_dsl.cli.recorded_runs import heed_answers, registry_of, registry_path
from ntp_dsl.cli.shown_beside import demonstration_file
from ntp_dsl.common.files import episode_files
from ntp_dsl.common.text import counted
from ntp_dsl.datasets.recording import RecordedDemonstration
from ntp_dsl.demonstrations.demonstration_files import read_demonstration
from ntp_dsl.evaluation.episodes import Evaluator, GivenLists, Plan
from ntp_dsl.evaluation.listening import as_lists
from ntp_dsl.language.diagnostics.diagnostics import NtpError
from ntp_dsl.traces.comparison.comparison import Comparison
from ntp_dsl.traces.comparison.comparison_rules import DivergenceKind
from ntp_dsl.traces.comparison.divergence import compare
from ntp_dsl.traces.reader import read_trace
from ntp_dsl.traces.schema import PolicyKind
from ntp_dsl.traces.trace import Trace
from ntp_dsl.worlds.protocol import UNDISTURBED


def command(
    file: Annotated[Path, typer.Argument(metavar="TRACE", help="A trace, complete or cut off.")],
    out: Annotated[Path, typer.Option(help="Folder for the new trace.")] = Path("rerun"),
    library: Annotated[
        Path | None, typer.Option(help="The library of the trace; by default the example that it names.")
    ] = None,
    model: Annotated[
        Path | None, typer.Option(help="Checkpoint; by default the one that the trace names.")
    ] = None,
    step: Step = False,
    stop_at: BreakAt = None,
    inject: Inject = None,
    watch: Watch = False,
    viewer: Viewer = None,
    json: Json = False,
) -> int:
    """Run again what a trace records: the same task, seed, disturbances and demonstration.

    A run that was killed is carried on to its end that way, and a failed episode of an evaluation can be
    stopped and stepped. At the end it says whether the run went as in the trace. Exit status: 0 as in the
    trace, as far as that goes; 1 otherwise; 2 misuse.

    Example: ntp trace rerun runs/episode_00012.trace.jsonl --break grasp
    """
    trace = read_trace(file)
    number = trace.header.episode or 0
    again, _ = episode_files(out, number)
    shown = demonstration_file(trace, file)
    check_no_input(again, [file])
    evaluator = Evaluator(_plan(trace, file, library, model, out))
    recorded = _recorded(trace, shown)
    if recorded is None and (trace.header.policy is PolicyKind.LEARNED or trace.header.said):
        evaluator.tell(_told_before(trace, file, evaluator))
    policy = evaluator.policy(recorded)
    heed_answers(trace, policy)
    with supervised(evaluator, number, step, stop_at or [], inject or [], watch, viewer) as supervisor:
        evaluator.episode(
            number,
            recorded,
            watch=None if json else LiveTree(evaluator.registry),
            policy=policy,
            supervisor=supervisor,
        )
    messages.print(f"wrote {again}")
    comparison = compare(trace, read_trace(again))
    return _told(comparison, json)


def _plan(trace: Trace, file: Path, library: Path | None, model: Path | None, out: Path) -> Plan:
    """Return the plan of a trace's run. Raises `NtpError` where the trace does not say enough."""
    header = trace.header
    registry_of(trace, library, file)  # raises for another library than the trace's
    if header.policy not in (PolicyKind.LEARNED, PolicyKind.SCRIPTED) or header.seed is None:
        raise NtpError(f"{file}: expected a trace of `ntp run` or `ntp eval`, found one by '{header.policy}'")
    path = model or (Path(header.model) if header.model else None)
    if header.policy is PolicyKind.LEARNED and (path is None or not path.is_file()):
        raise NtpError(f"{file}: its checkpoint, {header.model}, is not there: give --model FILE")
    return Plan(
        library or registry_path(trace),
        header.task,
        path if header.policy is PolicyKind.LEARNED else None,
        header.world or "kinematic",
        header.seed,
        header.disturbances or UNDISTURBED,
        traces=out,
        arm=header.arm,
        dispatch=header.dispatch,
    )


def _told_before(trace: Trace, file: Path, evaluator: Evaluator) -> GivenLists:
    """Return what a run was told, which was shown nothing."""
    if not trace.calls:
        raise NtpError(f"{file}: ends before the goal that was told: `ntp run --goal` runs it again")
    root = trace.calls[0]
    lists = as_lists(evaluator.registry, root.name, root.arguments)
    return GivenLists(lists, str(file), trace.header.said, trace.header.understood)


def _recorded(trace: Trace, shown: Path | None) -> RecordedDemonstration | None:
    reference = trace.header.demonstration
    if reference is None:
        return None
    if shown is None:
        raise NtpError(f"the demonstration of the trace, {reference.file}, does not lie beside it")
    return RecordedDemonstration(read_demonstration(shown, trace.header.objects), reference.calls)


def _told(comparison: Comparison, json: bool) -> int:
    """Say whether the run went as in the trace; where that was cut off, as far as it goes."""
    first = comparison.first
    is_longer = first is not None and first.kind is DivergenceKind.CUT_OFF and comparison.a.end is None
    same = first is None or is_longer
    if json:
        print_json({"same": same, "first": as_json(comparison, first) if first and not same else None})
    elif same:
        calls = counted(len(comparison.a.calls), "call")
        on = f", and went on: {counted(len(comparison.b.calls), 'call')} in all" if is_longer else ""
        answers.print(f"as in the trace: {calls}{on}", style="green")
    else:
        for row in report(comparison, everywhere=False):
            answers.print(row)
    return SAME if same else DIFFERENT
