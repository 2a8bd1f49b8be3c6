"""`ntp eval`: success over many episodes, and what failures are attributed to."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path
from typing import Annotated

import typer

from ntp_dsl.cli.display import answers, messages, print_json, progress
from ntp_dsl.cli.models import model_or_expert
from ntp_dsl.cli.options import (
    Arm,
    CameraOffset,
    DemoBy,
    DemoNoise,
    DemoRate,
    DispatchBy,
    Json,
    Latency,
    Length,
    Library,
    Model,
    Noise,
    Pushes,
    Scripted,
    Seed,
    Semantics,
    Slips,
    Spread,
    Task,
    Topology,
    WeakGrip,
    WholeScopes,
    Workers,
    WorldName,
    shown_at,
    varied,
)
from ntp_dsl.common.files import episode_files
from ntp_dsl.common.signals import uninterrupted
from ntp_dsl.evaluation.episodes import Episode, Plan, run_all
from ntp_dsl.evaluation.statistics import Confidence, Statistics, statistics
from ntp_dsl.language.diagnostics.diagnostics import NtpError
from ntp_dsl.worlds.protocol import Disturbances


def command(
    library: Library,
    task: Task,
    model: Model = None,
    dispatch: DispatchBy = None,
    expert: Scripted = False,
    world: WorldName = "kinematic",
    arm: Arm = None,
    episodes: Annotated[int, typer.Option("-n", "--episodes", min=1, help="Number of episodes.")] = 100,
    seed: Seed = 0,
    workers: Workers = 1,
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
    whole_scopes: WholeScopes = False,
    spoken: Annotated[
        bool,
        typer.Option(
            "--spoken",
            help="Put each demonstration in words, and tell the program these sentences alone; show nothing.",
        ),
    ] = False,
    tasks: Annotated[
        Path | None,
        typer.Option(
            help="A file of tasks (docs/task_files.md), ours or the paper's authors', in order, cyclically."
        ),
    ] = None,
    out: Annotated[Path | None, typer.Option(help="Folder for the traces.")] = None,
    length: Length = "",
    topology: Topology = "",
    semantics: Semantics = "",
    json: Json = False,
) -> int:
    """Run many episodes, each from one demonstration in another placement, and report their success.

    `success` is strict: all placements centred and in contact, no other object moved, the hand empty, and
    unchanged two seconds later. `success_authors` is the test of the paper's authors.
    After an interruption, the report is of the episodes so far. `confidence` is how probable the program
    finds it, on average, that it has done what was shown, where it succeeded and where it failed; AUROC is
    the chance that a success has more of it than a failure (1 is perfect, 0.5 is worthless).

    Example: ntp eval block_stacking block_stacking --world bullet --episodes 100 --json
    """
    path = model_or_expert(model, expert, dispatch)
    disturbances = Disturbances(
        slips, pushes, noise, latency=latency, camera_offset=camera_offset, spread=spread, weak_grip=weak_grip
    )
    ranges = varied(length, topology, semantics)
    if expert and (demo_noise or demo_by or whole_scopes):
        raise NtpError("--expert needs no demonstration: omit --demo-noise, --demo-by and --whole-scopes")
    if spoken and (expert or demo_noise or demo_by or whole_scopes):
        raise NtpError(
            "--spoken shows no demonstration: omit --expert, --demo-noise, --demo-by, --whole-scopes"
        )
    if tasks and ranges:
        raise NtpError(f"--{ranges[0][0]} is for drawn goals, and --tasks gives them: choose one")
    plan = Plan(
        library,
        task,
        path,
        world,
        seed,
        disturbances,
        tasks,
        out,
        ranges,
        arm=arm,
        demo_noise=demo_noise,
        demo_by=demo_by,
        demo_rate=shown_at(demo_by, demo_rate),
        whole_scopes=whole_scopes,
        dispatch=dispatch,
        spoken=spoken,
    )
    done: list[Episode] = []
    stopped: BaseException | None = None
    try:
        with progress("episodes", episodes) as bar:
            for episode in run_all(plan, episodes, workers):
                done.append(episode)
                wins = sum(bool(each.success) for each in done)
                bar.describe(f"{wins} of {len(done)} episodes")
                bar.advance()
    except (KeyboardInterrupt, ChildProcessError) as error:
        stopped = error
    with uninterrupted():
        if done:
            figures = statistics(done, seed)
            _report(figures, episodes, stopped is not None, json)
            if figures.failed and not json:
                messages.print(_hint(figures.failed[0].episode, out))
    if stopped is not None:
        raise stopped
    return 0


def _confidence(figures: Confidence) -> str:
    parts = [
        f"{value:.2f} where it {what}"
        for value, what in ((figures.of_successes, "succeeded"), (figures.of_failures, "failed"))
        if value is not None
    ]
    if figures.auroc is not None:
        parts.append(f"AUROC {figures.auroc:.2f}")
    return ", ".join(parts)


def _hint(failed: int, out: Path | None) -> str:
    """Return how to find out why an episode failed."""
    if out is None:
        return "why: run it again with --out DIR, and `ntp trace explain` says it from the traces"
    trace, _ = episode_files(out, failed)
    return f"why: ntp trace explain {trace}; of all: ntp trace report {out}"


def _report(figures: Statistics, wanted: int, interrupted: bool, json: bool) -> None:
    if json:
        print_json({**asdict(figures), "episodes_wanted": wanted, "interrupted": interrupted})
        return
    if interrupted:
        answers.print(f"interrupted after {figures.episodes} of {wanted} episodes")
    low, high = figures.success_interval
    answers.print(f"success          {figures.success:.3f}   (95 %: {low:.3f} to {high:.3f})")
    answers.print(f"authors' test    {figures.success_authors:.3f}")
    failures = ", ".join(f"{kind} {count}" for kind, count in figures.failures.items())
    answers.print(f"failures         {failures}")
    answers.print(f"disturbances     {figures.disturbances}")
    answers.print(
        f"per episode      {figures.seconds_per_episode:.2f} s, "
        f"simulated {figures.simulated_seconds_per_episode:.1f} s, "
        f"{figures.placements_per_episode:.1f} placements"
    )
    if figures.scopes:
        lowest, worst = min(figures.scopes.items(), key=lambda each: each[1].overlap)
        mean = sum(each.overlap for each in figures.scopes.values()) / len(figures.scopes)
        answers.print(
            f"scopes           {mean:.2f} overlap with the frames of the expert's calls "
            f"(least: {lowest} {worst.overlap:.2f})"
        )
    if figures.confidence is not None:
        answers.print(f"confidence       {_confidence(figures.confidence)}")
    for failure in figures.failed:
        sure = f" (confidence {failure.confidence:.0%})" if failure.confidence is not None else ""
        answers.print(f"episode {failure.episode}{sure}: {failure.attributed_to}: {failure.reason}")
