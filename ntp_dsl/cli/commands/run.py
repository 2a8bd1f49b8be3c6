"""`ntp run`: one episode of a task."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from ntp_dsl.cli.asking import answered
from ntp_dsl.cli.display import answers, messages, print_json
from ntp_dsl.cli.live import LiveTree
from ntp_dsl.cli.models import model_or_expert
from ntp_dsl.cli.options import (
    Arm,
    DemoBy,
    DemoNoise,
    DemoRate,
    DispatchBy,
    Gui,
    Json,
    Length,
    Library,
    Model,
    Noise,
    Pushes,
    Scripted,
    Seed,
    Semantics,
    Slips,
    Task,
    Topology,
    WorldName,
    optional_number,
    shown_at,
    varied,
)
from ntp_dsl.common.files import episode_files
from ntp_dsl.common.text import counted
from ntp_dsl.datasets.recording import RecordedDemonstration
from ntp_dsl.demonstrations.demonstration import Demonstration
from ntp_dsl.demonstrations.demonstration_files import read_demonstration
from ntp_dsl.evaluation.episodes import Evaluator, Plan
from ntp_dsl.evaluation.pictures import Camera
from ntp_dsl.language.diagnostics.diagnostics import NtpError, TaskFailed
from ntp_dsl.policies.protocol import Policy
from ntp_dsl.worlds.protocol import Disturbances

if TYPE_CHECKING:
    from ntp_dsl.core.shown import Shown


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
    dispatch: DispatchBy = None,
    expert: Scripted = False,
    world: WorldName = "bullet",
    seed: Seed = 0,
    slips: Slips = 0.0,
    pushes: Pushes = 0.0,
    noise: Noise = 0.0,
    demo_noise: DemoNoise = 0.0,
    demo_by: DemoBy = None,
    demo_rate: DemoRate = None,
    ask_below: Annotated[
        float | None,
        typer.Option(
            min=0,
            max=1,
            callback=optional_number,
            help="Ask which element is meant where none is that probable.",
        ),
    ] = None,
    answer: Annotated[
        list[int] | None, typer.Option(min=1, help="Answer to a question, by its number; once for each.")
    ] = None,
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
    that of a file, else one drawn from the seed. Exit status: 0 done, 1 the
    task failed, 2 misuse.

    Example: ntp run block_stacking block_stacking --seed 3 --out runs/three
    """
    if expert and demo:
        raise NtpError("--expert needs no --demo: the scripted expert decides")
    if (demo_noise or demo_by) and (demo or goal or expert):
        given = "--demo-noise" if demo_noise else "--demo-by"
        raise NtpError(f"{given} is for a demonstration that is recorded now, for a learned program: omit it")
    if ask_below is not None and (goal or expert):
        raise NtpError("--ask-below is for what a demonstration leaves open: omit it")
    if answer and ask_below is None:
        raise NtpError("--answer goes with --ask-below: say when to ask")
    if goal and demo:
        raise NtpError("--goal says what --demo shows: choose one")
    path = model_or_expert(model, expert, dispatch)
    ranges = varied(length, topology, semantics)
    disturbances = Disturbances(slips, pushes, noise)
    plan = Plan(
        library,
        task,
        path,
        world,
        seed,
        disturbances,
        traces=out,
        varied=ranges,
        gui=gui,
        arm=arm,
        demo_noise=demo_noise,
        demo_by=demo_by,
        demo_rate=shown_at(demo_by, demo_rate),
        dispatch=dispatch,
        goal=goal,
    )
    evaluator = Evaluator(plan)
    recorded = (
        RecordedDemonstration(read_demonstration(demo, evaluator.instance(0).objects)) if demo else None
    )
    if recorded is None and goal is None and not expert:
        messages.print(f"no --demo: the expert demonstrates the task once, from seed {seed}")
    policy = None
    if ask_below is not None and recorded is None:
        recorded, _ = evaluator.demonstration(evaluator.instance(0), 0)
    if recorded is not None and not expert:
        policy = evaluator.policy(recorded)
        if ask_below is not None:
            _ask(evaluator, policy, recorded.demonstration, ask_below, answer or [])
        _warn(evaluator, policy)
    run_episode(evaluator, recorded, out, json, policy)
    return 0


def _warn(evaluator: Evaluator, policy: Policy) -> None:
    """Say so where a demonstration is not understood whole."""
    source, instance = _source(policy), evaluator.instance(0)
    if source is None or not evaluator.registry.programs[instance.program].takes_list:
        return
    reading = source.reading(instance.program, instance.arguments, source.scope())
    if not reading.is_whole:
        messages.print(
            f"only {reading.explained} of {counted(reading.acts, 'act')} of the hand are explained; "
            "`ntp read` prints what was understood"
        )


def _source(policy: Policy) -> Shown | None:
    """Return the demonstration as the one core reads it; None for the baseline."""
    from ntp_dsl.core.policy import OneShotPolicy
    from ntp_dsl.core.shown import Shown

    return policy.source if isinstance(policy, OneShotPolicy) and isinstance(policy.source, Shown) else None


def _ask(
    evaluator: Evaluator, policy: Policy, shown: Demonstration, threshold: float, answers: list[int]
) -> None:
    """Ask which elements of the program's lists are meant, where the demonstration does not tell."""
    instance, source = evaluator.instance(0), _source(policy)
    if source is None:
        raise NtpError("a checkpoint of `ntp train` says nothing of what it reads: omit --ask-below")
    scope = source.scope()
    reading = source.reading(instance.program, instance.arguments, scope)
    doubts = [each for each in reading.doubts if each.probability < threshold]
    meant = answered(evaluator.registry, shown, doubts, answers)
    source.settle(instance.program, instance.arguments, scope, meant)


def run_episode(
    evaluator: Evaluator,
    recorded: RecordedDemonstration | None,
    out: Path | None,
    json: bool,
    policy: Policy | None = None,
) -> None:
    """Run one episode and show its calls. Raises `TaskFailed` with the reason where it fails."""
    camera = _camera(evaluator, out)
    episode = evaluator.episode(
        0,
        recorded,
        watch=None if json else LiveTree(evaluator.registry),
        on_frame=camera.frame if camera else None,
        policy=policy,
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
        raise TaskFailed(f"the task failed ({episode.attributed_to}): {episode.reason}")
    if json:
        return
    work = f"{counted(episode.primitives, 'primitive')}, {episode.simulated_seconds:.1f} s of robot time"
    if episode.success is None:
        messages.print("the demonstration states no goal, so the result was not judged")
        answers.print(f"finished, not judged: {work}")
    else:
        answers.print(f"done: {counted(episode.placements, 'placement')}, {work}")


def _camera(evaluator: Evaluator, out: Path | None) -> Camera | None:
    """Return a camera where there is a folder for pictures and the world can render itself."""
    render = getattr(evaluator.world, "render", None)
    return Camera(render, out) if out is not None and render is not None else None
