"""`ntp pretrain`: the core that runs any library."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import asdict
from importlib.metadata import version
from pathlib import Path
from time import perf_counter
from typing import Annotated, Any

import numpy as np
import typer

from ntp_dsl.cli.display import messages, print_json, progress
from ntp_dsl.cli.options import Json, Seed
from ntp_dsl.core.one_core import MADE_BY, OneCore, save_one_core
from ntp_dsl.core.pretraining.config import PretrainingConfig
from ntp_dsl.core.pretraining.dispatch_data import Sample
from ntp_dsl.core.pretraining.fitting import Fit, Progress
from ntp_dsl.core.pretraining.grounding_data import joined, of_scene
from ntp_dsl.core.pretraining.library_episodes import decisions
from ntp_dsl.core.pretraining.nameless_programs import nameless
from ntp_dsl.core.pretraining.nameless_sequences import sequence
from ntp_dsl.core.pretraining.pretraining import Pretraining

SAVE_EVERY = 500  # iterations
SHOW_EVERY = 50
FIRST_LIBRARY, LIBRARIES_OF_SEED = 1_000_000, 10_000  # numbers of random libraries that are trained on


def command(
    out: Annotated[Path, typer.Option(help="Folder to write.")] = Path("runs/core"),
    scenes: Annotated[int, typer.Option(min=1, help="Number of made-up scenes.")] = PretrainingConfig.scenes,
    iterations: Annotated[
        int, typer.Option(min=1, help="Number of optimiser steps of the grounding.")
    ] = PretrainingConfig.iterations,
    programs: Annotated[
        int, typer.Option(min=1, help="Number of nameless random programs.")
    ] = PretrainingConfig.programs,
    sequences: Annotated[
        int, typer.Option(min=0, help="Number of nameless sequences, in which one call needs another.")
    ] = PretrainingConfig.sequences,
    libraries: Annotated[
        int, typer.Option(min=0, max=LIBRARIES_OF_SEED, help="Number of random libraries.")
    ] = PretrainingConfig.libraries,
    dispatch_iterations: Annotated[
        int, typer.Option(min=1, help="Number of optimiser steps of the dispatcher.")
    ] = PretrainingConfig.dispatch_iterations,
    seed: Seed = 0,
    json: Json = False,
) -> int:
    """Make the core that runs any library: it learns to see which facts hold, and to decide in doubt.

    It needs no data: scenes, programs and libraries are made up. The same seed gives the same weights, bit
    for bit. After an interruption, the same command continues from the last saved iteration.

    Example: ntp pretrain --out runs/core
    """
    started = perf_counter()
    config = PretrainingConfig(seed, scenes, iterations, programs, sequences, libraries, dispatch_iterations)
    training = Pretraining(config)
    out.mkdir(parents=True, exist_ok=True)
    partial = out / "pretraining.safetensors"
    if partial.exists():
        training.resume(partial)
        done = training.grounding.iteration + training.dispatch.iteration
        messages.print(f"continuing from iteration {done} of {partial}")
    with _kept(training, partial):
        _fit_grounding(training, partial)
        _fit_dispatch(training, partial)
    recipe = {
        "made_by": MADE_BY,
        "pretraining": asdict(config),
        "versions": {name: version(name) for name in ("ntp_dsl", "torch", "numpy")},
    }
    path = out / "core.safetensors"
    save_one_core(OneCore(training.grounding.network, training.dispatch.network, recipe), path)
    partial.unlink(missing_ok=True)
    seconds = round(perf_counter() - started, 1)
    if json:
        print_json({"checkpoint": str(path), "seconds": seconds, **recipe})
    else:
        messages.print(f"{path}: {seconds} s")
    return 0


@contextmanager
def _kept(training: Pretraining, partial: Path) -> Iterator[None]:
    """Save what is done where the user interrupts."""
    try:
        yield
    except KeyboardInterrupt:
        training.save(partial)
        raise


def _fit_grounding(training: Pretraining, partial: Path) -> None:
    if training.grounding.is_done:
        return
    config = training.config
    found = []
    with progress("making up scenes", config.scenes) as bar:
        for number in range(config.scenes):
            found += of_scene(number, config.seed)
            bar.advance()
    with _reporting("grounding", training, training.grounding, partial) as report:
        training.fit_grounding(joined(found), report)


def _fit_dispatch(training: Pretraining, partial: Path) -> None:
    if training.dispatch.is_done:
        return
    config = training.config
    nameless_ones: list[Sample] = []
    in_sequence: list[Sample] = []
    in_libraries: list[Sample] = []
    with progress("making up programs", config.programs + config.sequences + config.libraries) as bar:
        for number in range(config.programs):
            sample = nameless(np.random.default_rng((config.seed, number)))
            nameless_ones += [sample] if sample is not None else []
            bar.advance()
        for number in range(config.sequences):
            in_sequence += sequence(np.random.default_rng((config.seed, number)))
            bar.advance()
        for number in range(config.libraries):
            library = FIRST_LIBRARY + config.seed * LIBRARIES_OF_SEED + number
            in_libraries += decisions(library, training.grounding.network)
            bar.advance()
    with _reporting("dispatching", training, training.dispatch, partial) as report:
        training.fit_dispatch([nameless_ones, in_libraries], in_sequence, report)


@contextmanager
def _reporting(name: str, training: Pretraining, fit: Fit[Any], partial: Path) -> Iterator[Progress]:
    with progress(name, fit.iterations) as bar:
        bar.advance(fit.iteration)

        def report(iteration: int, loss: float) -> None:
            bar.advance()
            if iteration % SHOW_EVERY == 0:
                bar.describe(f"{name}, loss {loss:.3f}")
            if iteration % SAVE_EVERY == 0:
                training.save(partial)

        yield report
