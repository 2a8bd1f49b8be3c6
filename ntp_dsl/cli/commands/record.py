"""`ntp record`: demonstrations and labelled traces of the expert."""

from __future__ import annotations

import sys
from hashlib import sha256
from pathlib import Path
from typing import Annotated

import typer

from ntp_dsl.cli.display import messages, print_json, progress
from ntp_dsl.cli.options import (
    Arm,
    Json,
    Length,
    Library,
    Seed,
    Semantics,
    Task,
    Topology,
    Workers,
    WorldName,
    number,
    varied,
)
from ntp_dsl.datasets.dataset import RecordingPlan, record
from ntp_dsl.datasets.recording import PERTURBATION_RATE
from ntp_dsl.language.diagnostics.diagnostics import TaskFailed
from ntp_dsl.tasks.instances import Configuration, configuration
from ntp_dsl.tasks.task_files import read_tasks


def command(
    library: Library,
    task: Task,
    episodes: Annotated[int, typer.Option("-n", "--episodes", min=1, help="Number of episodes.")] = 100,
    out: Annotated[Path, typer.Option(help="Folder to write.")] = Path("runs/data"),
    world: WorldName = "kinematic",
    arm: Arm = None,
    seed: Seed = 0,
    workers: Workers = 1,
    perturbation_rate: Annotated[
        float,
        typer.Option(
            min=0,
            max=1,
            callback=number,
            help="Probability of slips, pushes and wrong subprograms, per primitive.",
        ),
    ] = PERTURBATION_RATE,
    exclude: Annotated[
        list[Path] | None,
        typer.Option(help="A task file whose goal configurations are never drawn; may be repeated."),
    ] = None,
    say: Annotated[
        bool, typer.Option("--say", help="Write beside each demonstration what it shows, as sentences.")
    ] = False,
    overwrite: Annotated[
        bool, typer.Option("--overwrite", help="Record into a folder that holds other files, too.")
    ] = False,
    length: Length = "",
    topology: Topology = "",
    semantics: Semantics = "",
    json: Json = False,
) -> int:
    """Record demonstrations and labelled traces from the scripted expert.

    Each episode has an undisturbed demonstration from one placement, and a labelled run from another with
    slips, pushes and wrong subprograms, so that recovery is learnt too. The manifest lists failed episodes.
    With --say, `ntp run --say` takes the sentences in place of the demonstration.

    Example: ntp record block_stacking block_stacking -n 300 --out runs/data
    """
    files = exclude or []
    hashes = tuple((path.name, sha256(path.read_bytes()).hexdigest()) for path in files)
    command_line = "ntp " + " ".join(sys.argv[1:])
    ranges = varied(length, topology, semantics)
    plan = RecordingPlan(
        library,
        task,
        out,
        world,
        seed,
        perturbation_rate,
        _excluded(files),
        command_line,
        hashes,
        ranges,
        arm,
        say,
        overwrite,
    )
    failed = []
    with progress("recording", episodes) as bar:
        for row in record(plan, episodes, workers):
            bar.advance()
            if not row.is_kept:
                failed.append(row)
    kept = episodes - len(failed)
    for row in failed:
        messages.print(f"episode {row.number}: {row.outcome}: {row.reason}")
    if json:
        print_json({"out": str(out), "episodes": episodes, "kept": kept, "seed": seed})
    else:
        messages.print(f"{kept} of {episodes} episodes in {out}")
    if not kept:
        raise TaskFailed("no episode succeeded: see the manifest for the reasons")
    return 0


def _excluded(files: list[Path]) -> frozenset[Configuration]:
    return frozenset(configuration(entry.goal) for path in files for entry in read_tasks(path))
