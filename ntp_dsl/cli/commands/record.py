"""`ntp record`: demonstrations and labelled traces from the expert."""

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
    episodes: Annotated[int, typer.Option("-n", "--episodes", min=1, help="How many to record.")] = 100,
    out: Annotated[Path, typer.Option(help="The folder to write.")] = Path("runs/data"),
    world: WorldName = "kinematic",
    arm: Arm = None,
    seed: Seed = 0,
    workers: Workers = 1,
    perturbation_rate: Annotated[
        float,
        typer.Option(min=0, max=1, help="How often an object slips or a wrong subprogram runs."),
    ] = PERTURBATION_RATE,
    exclude: Annotated[
        list[Path] | None,
        typer.Option(help="A task file whose labelled end configurations are never drawn."),
    ] = None,
    length: Length = "",
    topology: Topology = "",
    semantics: Semantics = "",
    json: Json = False,
) -> int:
    """Record demonstrations and labelled traces from the scripted expert.

    Each episode is a clean demonstration from one start, and a labelled episode from another in which objects
    slip and fall and wrong subprograms run, so that recoveries are learnt too. Failed ones are named in the
    manifest.

    Example: ntp record block_stacking block_stacking -n 300 --out runs/data
    """
    files = exclude or []
    hashes = tuple((path.name, sha256(path.read_bytes()).hexdigest()) for path in files)
    words = "ntp " + " ".join(sys.argv[1:])
    ranges = varied(length, topology, semantics)
    plan = RecordingPlan(
        library, task, out, world, seed, perturbation_rate, _excluded(files), words, hashes, ranges, arm
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
        raise TaskFailed("no episode went well: see the manifest for the reasons")
    return 0


def _excluded(files: list[Path]) -> frozenset[Configuration]:
    return frozenset(configuration(entry.goal) for path in files for entry in read_tasks(path))
