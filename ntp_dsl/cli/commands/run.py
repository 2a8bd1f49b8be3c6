"""`ntp run`: one episode of a task."""

from __future__ import annotations

from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Annotated, Any

import typer

from ntp_dsl.cli.dialogue.asking import Interview
from ntp_dsl.cli.dialogue.saying import changed, sentences_of, told
from ntp_dsl.cli.display import answers, messages, print_json
from ntp_dsl.cli.live_runs.call_tree import LiveTree
from ntp_dsl.cli.live_runs.stepping import supervised
from ntp_dsl.cli.models import model_or_expert
from ntp_dsl.cli.options import (
    Arm,
    BreakAt,
    CameraOffset,
    DemoBy,
    DemoNoise,
    DemoRate,
    DispatchBy,
    Gui,
    Inject,
    Json,
    Latency,
    Length,
    Library,
    Model,
    Noise,
    Pushes,
    Say,
    Scripted,
    Seed,
    Semantics,
    Slips,
    Spread,
    Step,
    Task,
    Topology,
    Viewer,
    Watch,
    WeakGrip,
    WorldName,
    optional_number,
    shown_at,
    varied,
)
from ntp_dsl.common.files import episode_files
from ntp_dsl.common.text import counted
from ntp_dsl.datasets.recording import RecordedDemonstration
from ntp_dsl.demonstrations.demonstration_files import read_demonstration
from ntp_dsl.evaluation.demonstration_remarks import remarks
from ntp_dsl.evaluation.episode_parts import NoDemonstration
from ntp_dsl.evaluation.episodes import Evaluator, GivenLists, Plan
from ntp_dsl.evaluation.pictures import Camera
from ntp_dsl.execution.supervision import Supervisor
from ntp_dsl.language.diagnostics.diagnostics import NtpError, TaskFailed
from ntp_dsl.policies.protocol import Policy
from ntp_dsl.tasks.goal_text import read_lists
from ntp_dsl.traces.decision import Dispatch
from ntp_dsl.worlds.protocol import Disturbances

if TYPE_CHECKING:
    from ntp_dsl.core.shown import Shown


def _probability(help: str) -> Any:
    return typer.Option(min=0, max=1, callback=optional_number, help=help)


def command(
    library: Library,
    task: Task,
    model: Model = None,
    demo: Annotated[
        Path | None,
        typer.Option(help="A demonstration file; by default the expert records one from the seed."),
    ] = None,
    goal: Annotated[
        Path | None,
        typer.Option(help="A file with the goal, as `ntp read` prints it; nothing is demonstrated then."),
    ] = None,
    say: Say = None,
    dispatch: DispatchBy = None,
    expert: Scripted = False,
    world: WorldName = "bullet",
    seed: Seed = 0,
    slips: Slips = 0.0,
    pushes: Pushes = 0.0,
    noise: Noise = 0.0,
    latency: Latency = 0.0,
    camera_offset: CameraOffset = 0.0,
    spread: Spread = 0.0,
    weak_grip: WeakGrip = 0.0,
    demo_noise: DemoNoise = 0.0,
    demo_by: DemoBy = None,
    demo_rate: DemoRate = None,
    ask_below: Annotated[
        float | None,
        _probability("Ask which elements are meant, and whether all is done, where less probable than this."),
    ] = None,
    ask_calls_below: Annotated[
        float | None,
        _probability("Ask what a program is to do next, where less probable than this; needs --ask-below."),
    ] = None,
    answer: Annotated[
        list[int] | None,
        typer.Option(min=1, help="Answer to a question, by number; repeat it for each question, in order."),
    ] = None,
    step: Step = False,
    stop_at: BreakAt = None,
    inject: Inject = None,
    watch: Watch = False,
    viewer: Viewer = None,
    arm: Arm = None,
    gui: Gui = False,
    out: Annotated[Path | None, typer.Option(help="Folder for the trace and pictures.")] = None,
    length: Length = "",
    topology: Topology = "",
    semantics: Semantics = "",
    json: Json = False,
) -> int:
    """Run a task: learned from one demonstration, or by the scripted expert.

    Any sound library runs, without training. With --demo the goal is that of the demonstration, with --goal
    that of a file, with --say what sentences say, else one drawn from the seed. With --demo and --say, the
    sentences change what the demonstration shows. With --step and --break it can be stopped, with --watch and
    --viewer followed. Exit status: 0 done, 1 the task failed, 2 misuse.

    Example: ntp run block_stacking block_stacking --seed 3 --out runs/three
    """
    if expert and demo:
        raise NtpError("--expert needs no --demo: the scripted expert decides")
    if (demo_noise or demo_by) and (demo or goal or expert or say):
        given = "--demo-noise" if demo_noise else "--demo-by"
        raise NtpError(f"{given} is for a demonstration that is recorded now, for a learned program: omit it")
    if ask_below is not None and expert:
        raise NtpError("--ask-below is for what a learned program leaves open: omit it")
    if ask_calls_below is not None and ask_below is None:
        raise NtpError("--ask-calls-below goes with --ask-below: add it")
    if ask_calls_below is not None and dispatch is Dispatch.RULE:
        raise NtpError("--dispatch rule weighs no alternatives: omit --ask-calls-below")
    if answer and ask_below is None and not say:
        raise NtpError("--answer goes with --ask-below, or with --say: say when to ask")
    if watch and ask_below is not None:
        raise NtpError("--ask-below asks at the terminal, which --watch listens to: omit one of them")
    if goal and (demo or say):
        raise NtpError(f"--goal says what {'--demo shows' if demo else '--say says'}: choose one")
    sentences = sentences_of(say) if say else []
    path = model_or_expert(model, expert, dispatch)
    scratch = TemporaryDirectory(prefix="ntp_run_") if (watch or viewer) and out is None else None
    ranges = varied(length, topology, semantics)
    disturbances = Disturbances(
        slips, pushes, noise, latency=latency, camera_offset=camera_offset, spread=spread, weak_grip=weak_grip
    )
    plan = Plan(
        library,
        task,
        path,
        world,
        seed,
        disturbances,
        traces=out or (Path(scratch.name) if scratch else None),
        varied=ranges,
        gui=gui,
        arm=arm,
        demo_noise=demo_noise,
        demo_by=demo_by,
        demo_rate=shown_at(demo_by, demo_rate),
        dispatch=dispatch,
    )
    evaluator = Evaluator(plan)
    interview = Interview(evaluator.registry, answer or [], out)
    recorded = (
        RecordedDemonstration(read_demonstration(demo, evaluator.instance(0).objects)) if demo else None
    )
    if recorded is not None:
        for remark in remarks(evaluator.registry, evaluator.instance(0), recorded.demonstration):
            messages.print(remark, style="yellow")
    if goal is not None:
        instance = evaluator.instance(0)
        program = evaluator.registry.programs[instance.program]
        lists = read_lists(goal, evaluator.registry, program, instance.objects)
        evaluator.tell(GivenLists(lists, str(goal)))
    elif sentences and recorded is not None:
        evaluator.tell(_changed(evaluator, recorded, sentences))
        recorded = None
    elif sentences:
        evaluator.tell(told(evaluator, sentences, interview))
    elif recorded is None and not expert:
        messages.print(f"no --demo: the expert demonstrates the task once, from seed {seed}")
        try:
            recorded, _ = evaluator.demonstration(evaluator.instance(0), 0)
        except NoDemonstration:
            _print_hint(out)
            raise
    policy = evaluator.policy(recorded) if recorded is not None or ask_below is not None else None
    if policy is not None and ask_below is not None:
        _prepare(evaluator, policy, interview, ask_below, ask_calls_below or 0.0)
    if policy is not None and recorded is not None:
        _look_through(evaluator, policy)
    try:
        with supervised(evaluator, 0, step, stop_at or [], inject or [], watch, viewer) as supervisor:
            run_episode(evaluator, recorded, out, json, policy, supervisor)
    finally:
        if scratch is not None:
            scratch.cleanup()
        if interview.unused:
            verb = "was" if interview.unused == 1 else "were"
            messages.print(f"{counted(interview.unused, 'answer')} {verb} not used: nothing else was asked")
    return 0


def _changed(evaluator: Evaluator, recorded: RecordedDemonstration, sentences: list[str]) -> GivenLists:
    """Return what a demonstration shows, as sentences change it."""
    source = _source(evaluator, evaluator.policy(recorded))
    if source is None:
        raise NtpError("--say changes lists, and the task's program takes none: omit it")
    instance = evaluator.instance(0)
    reading = source.reading(instance.program, instance.arguments, source.scope())
    return changed(evaluator, reading.arguments, sentences, reading.probability)


def _prepare(
    evaluator: Evaluator, policy: Policy, interview: Interview, ask_below: float, calls_below: float
) -> None:
    """Ask which elements of the program's lists are meant, and let the policy ask while it runs."""
    from ntp_dsl.core.asking import Asking
    from ntp_dsl.core.policy import OneShotPolicy

    if not isinstance(policy, OneShotPolicy):
        raise NtpError("a checkpoint of `ntp train` says nothing of what it reads: omit --ask-below")
    policy.adviser = Asking(interview.decision, ask_below, calls_below)
    source = _source(evaluator, policy)
    if source is None:
        return
    instance = evaluator.instance(0)
    wanted = instance.program, instance.arguments, source.scope()
    doubts = [each for each in source.reading(*wanted).doubts if each.probability < ask_below]
    if meant := interview.elements(source, doubts):
        source.settle(*wanted, meant)


def _look_through(evaluator: Evaluator, policy: Policy) -> None:
    """Say so where not all of a demonstration is understood."""
    source = _source(evaluator, policy)
    if source is None:
        return
    instance = evaluator.instance(0)
    reading = source.reading(instance.program, instance.arguments, source.scope())
    if not reading.is_whole:
        messages.print(
            f"only {reading.explained} of {counted(reading.acts, 'act')} of the hand are explained; "
            "`ntp read` prints what was understood"
        )


def _source(evaluator: Evaluator, policy: Policy) -> Shown | None:
    """Return the demonstration that a task's program reads its lists from; None where it reads none."""
    from ntp_dsl.core.policy import OneShotPolicy
    from ntp_dsl.core.shown import Shown

    if not isinstance(policy, OneShotPolicy) or not isinstance(policy.source, Shown):
        return None
    takes_list = evaluator.registry.programs[evaluator.instance(0).program].takes_list
    return policy.source if takes_list else None


def run_episode(
    evaluator: Evaluator,
    recorded: RecordedDemonstration | None,
    out: Path | None,
    json: bool,
    policy: Policy | None = None,
    supervisor: Supervisor | None = None,
) -> None:
    """Run one episode and show its calls. Raises `TaskFailed` with the reason where it fails."""
    camera = _camera(evaluator, out)
    episode = evaluator.episode(
        0,
        recorded,
        watch=None if json else LiveTree(evaluator.registry),
        on_frame=camera.frame if camera else None,
        policy=policy,
        supervisor=supervisor,
    )
    files = []
    if out is not None:
        files += [path for path in episode_files(out, 0) if path.is_file()]
    if camera is not None and out is not None:
        camera.take()
        for path, write in (
            (out / "strip.png", camera.write_strip),
            (out / "arm.gif", camera.write_animation),
        ):
            write(path)
            files.append(path)
    if json:
        print_json(
            {
                "success": episode.success,
                "success_authors": episode.success_authors,
                "confidence": episode.confidence,
                "attributed_to": episode.attributed_to,
                "reason": episode.reason,
                "primitives": episode.primitives,
                "simulated_seconds": episode.simulated_seconds,
                "seconds": round(episode.wall_seconds, 3),
                "files": [str(path) for path in files],
            }
        )
    for path in files:
        messages.print(f"wrote {path}")
    if episode.success is False:
        _print_hint(out)
        raise TaskFailed(f"the task failed ({episode.attributed_to}): {episode.reason}")
    if json:
        return
    work = f"{counted(episode.primitives, 'primitive')}, {episode.simulated_seconds:.1f} s of robot time"
    if episode.confidence is not None:
        work += f", confidence {episode.confidence:.0%}"
    if episode.success is None:
        messages.print("the demonstration states no goal, so the result was not judged")
        answers.print(f"finished, not judged: {work}")
    else:
        answers.print(f"done: {counted(episode.placements, 'placement')}, {work}")


def _print_hint(out: Path | None) -> None:
    """Say how to find out why a task failed, where there is a trace of it."""
    if out is not None:
        messages.print(f"why: ntp trace explain {episode_files(out, 0)[0]}")


def _camera(evaluator: Evaluator, out: Path | None) -> Camera | None:
    """Return a camera where there is a folder for pictures and the world can render itself."""
    render = getattr(evaluator.world, "render", None)
    return Camera(render, out) if out is not None and render is not None else None
