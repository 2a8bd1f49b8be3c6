"""`ntp train`: a checkpoint from recorded episodes."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import asdict
from importlib.metadata import version
from pathlib import Path
from time import perf_counter
from typing import Annotated, Any

import typer

from ntp_dsl.cli.display import messages, print_json, progress
from ntp_dsl.cli.options import Json, Library, Seed
from ntp_dsl.cli.row_training import train_row
from ntp_dsl.core.per_library.checkpoint import resume_training, save_core, save_training
from ntp_dsl.core.per_library.config import TrainingConfig
from ntp_dsl.core.per_library.corpus import Corpus
from ntp_dsl.core.per_library.memory import Memory
from ntp_dsl.core.per_library.sizing import sized
from ntp_dsl.core.per_library.training import Trainer, use_threads
from ntp_dsl.datasets.dataset import samples
from ntp_dsl.datasets.labels import LabelConfig
from ntp_dsl.datasets.manifest import Manifest, read_manifest
from ntp_dsl.demonstrations.queries import Sample
from ntp_dsl.language.diagnostics.diagnostics import NtpError
from ntp_dsl.language.registry import Registry
from ntp_dsl.user_code.loading import load_with_python

SAVE_EVERY = 200  # iterations
SHOW_EVERY = 20


def command(
    library: Library,
    data: Annotated[list[Path], typer.Option(help="Folder of `ntp record`; may be repeated.")],
    out: Annotated[
        Path | None,
        typer.Option(
            help="Folder to write; with --program the file.",
            show_default="runs/model, or beside the library",
        ),
    ] = None,
    program: Annotated[
        str | None,
        typer.Option(help="Learn the row of this program alone, for the core that ships; it takes seconds."),
    ] = None,
    iterations: Annotated[
        int, typer.Option(min=1, help="Number of optimiser steps.")
    ] = TrainingConfig.iterations,
    seed: Seed = 0,
    threads: Annotated[int, typer.Option(min=1, max=256, help="Number of processor threads.")] = 1,
    json: Json = False,
) -> int:
    """Train a core on the recorded traces of a library's expert.

    With --program NAME it learns what that program calls, if its expert is a function in Python, and which of
    the calls that are due come first, as far as the expert's traces show it (`ntp record`, or `ntp eval
    --expert --out`). The row is written beside the library, as NAME.rows.json, where the core that ships
    finds it. Without --program, it trains a core of the library's own, the baseline; after an interruption,
    the same command continues from the last saved iteration.

    Example: ntp train block_stacking --data runs/data --out runs/model
    """
    if program is not None:
        if (iterations, seed, threads) != (TrainingConfig.iterations, 0, 1):
            raise NtpError(
                "--program goes without --iterations, --seed and --threads: a row is fitted at once"
            )
        return train_row(library, program, data, out, json)
    out = out or Path("runs/model")
    use_threads(threads)
    registry = load_with_python(library)
    started = perf_counter()
    manifests = [read_manifest(folder, registry) for folder in data]
    labels = LabelConfig()
    labelled = _labelled(registry, data, manifests, seed, labels)
    if not labelled:
        raise NtpError(f"{', '.join(map(str, data))}: no episode was kept, so there is nothing to train on")
    if of_state := [each.name for each in registry.predicates.values() if each.is_state]:
        messages.print(
            f"this core does not see facts of the state ({', '.join(of_state)}): it cannot "
            "learn what depends on them; the one that ships sees them, and needs no training"
        )
    memory = Memory.of(registry)
    corpus = Corpus(memory, labelled, lambda name: registry.programs[name].takes_list)
    config = TrainingConfig(seed=seed, iterations=iterations)
    demonstrations = {sample.query.demonstration for sample in labelled}
    trainer = Trainer(sized(memory, demonstrations), config, memory)
    out.mkdir(parents=True, exist_ok=True)
    partial = out / "training.safetensors"
    data_facts = [_provenance(manifest) for manifest in manifests]
    if partial.exists():
        resume_training(trainer, partial, data_facts)
        messages.print(f"continuing from iteration {trainer.iteration} of {partial}")
    parts = _train(trainer, corpus, partial, data_facts)
    recipe = {
        "command": "ntp " + " ".join(sys.argv[1:]),
        "training": asdict(config),
        "labels": asdict(labels),
        "data": data_facts,
        "queries": len(labelled),
        "seconds": round(perf_counter() - started, 1),
        "versions": {name: version(name) for name in ("ntp_dsl", "torch", "numpy")},
    }
    path = out / f"{registry.name}.safetensors"
    with _kept(partial):
        save_core(trainer.core, recipe, path)
    partial.unlink(missing_ok=True)
    if json:
        print_json({"checkpoint": str(path), "loss": parts, **recipe})
    else:
        messages.print(f"{path}: {len(labelled)} queries, {recipe['seconds']} s")
    return 0


def _labelled(
    registry: Registry, folders: list[Path], manifests: list[Manifest], seed: int, labels: LabelConfig
) -> list[Sample]:
    found: list[Sample] = []
    total = sum(len(manifest.episodes) for manifest in manifests)
    with progress("labelling", total) as bar:
        for folder, manifest in zip(folders, manifests, strict=True):
            for episode in samples(registry, folder, manifest, seed, labels):
                found += episode
                bar.advance()
    return found


def _train(trainer: Trainer, corpus: Corpus, partial: Path, data: list[dict[str, Any]]) -> dict[str, float]:
    latest: dict[str, float] = {}
    with progress("training", trainer.config.iterations) as bar:
        bar.advance(trainer.iteration)

        def report(iteration: int, parts: dict[str, float]) -> None:
            latest.update(parts)
            bar.advance()
            if iteration % SHOW_EVERY == 0:
                bar.describe(f"training, loss {sum(parts.values()):.3f}")
            if iteration % SAVE_EVERY == 0 or iteration == trainer.config.iterations:
                with _kept(partial):
                    save_training(trainer, partial, data)

        try:
            trainer.run(corpus, report)
        except KeyboardInterrupt:
            save_training(trainer, partial, data)
            raise
    return {name: round(value, 5) for name, value in latest.items()}


@contextmanager
def _kept(partial: Path) -> Iterator[None]:
    """Say what is left of the training where a file cannot be written, as on a full disk."""
    try:
        yield
    except OSError as error:
        if not partial.is_file():
            raise
        raise NtpError(
            f"{error.filename}: {error.strerror}; the training so far is in {partial}: "
            "make room, and the same command continues from there"
        ) from error


def _provenance(manifest: Manifest) -> dict[str, Any]:
    """Return the origin of a data set, so that it can be recorded again."""
    keys = "command task world seed perturbation_rate excluded excluded_files registry versions".split()
    rows = manifest.episodes
    facts = {key: getattr(manifest, key) for key in keys}
    return facts | {"episodes": len(rows), "kept": sum(row.is_kept for row in rows)}
