"""Folders of recorded episodes: demonstrations, traces of labelled episodes, and a manifest of them all."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from importlib.metadata import version
from pathlib import Path

import numpy as np

from ntp_dsl.common.files import EPISODE_FILE, LOCK, episode_files, locked, sentences_file, written_whole
from ntp_dsl.common.seeds import derived
from ntp_dsl.common.workers import in_order
from ntp_dsl.datasets.labels import LabelConfig, labelled
from ntp_dsl.datasets.manifest import (
    FORMAT,
    MANIFEST,
    VERSION,
    Manifest,
    Recorded,
    RecordedEpisode,
    recorded_files,
    write_manifest,
)
from ntp_dsl.datasets.recording import (
    PERTURBATION_RATE,
    RecordedDemonstration,
    demonstrate,
    demonstration_start,
    record_episode,
)
from ntp_dsl.datasets.wording import in_words
from ntp_dsl.demonstrations.demonstration_files import read_demonstration, write_demonstration
from ntp_dsl.demonstrations.queries import Sample
from ntp_dsl.language.diagnostics.diagnostics import NtpError
from ntp_dsl.language.registry import Registry
from ntp_dsl.language.syntax.nodes import TaskDeclaration
from ntp_dsl.policies.expert import Expert
from ntp_dsl.semantics.observation import Observation
from ntp_dsl.semantics.value_checks import OutOfRange
from ntp_dsl.tasks.instances import Configuration, Instance, draw, end_configuration, find_task
from ntp_dsl.traces.reader import read_trace
from ntp_dsl.traces.writer import TraceWriter
from ntp_dsl.user_code.loading import load_with_python
from ntp_dsl.worlds.catalogue import make_world
from ntp_dsl.worlds.protocol import World

LABELS = LabelConfig()
REDRAWS = 1000  # of a goal that is excluded


@dataclass(frozen=True)
class RecordingPlan:
    """The settings of a recording, which can be sent to workers."""

    library: Path
    task: str
    out: Path
    world: str = "kinematic"
    seed: int = 0
    perturbation_rate: float = PERTURBATION_RATE
    excluded: frozenset[Configuration] = frozenset()
    command: str = ""  # as it was typed, for the manifest
    excluded_files: tuple[tuple[str, str], ...] = ()  # name and sha256
    varied: tuple[tuple[str, tuple[int, int]], ...] = ()  # length, topology, semantics -> range
    arm: str | None = None  # of a world with one; the Panda by default
    say: bool = False  # whether each demonstration is put in words, too
    overwrite: bool = False  # whether the folder may hold what no recording's manifest names


class EpisodeRecorder:
    """Records episodes in one process. Episode n depends on the plan and n alone."""

    def __init__(self, plan: RecordingPlan) -> None:
        self.plan = plan
        self.registry = load_with_python(plan.library)
        self.expert = Expert(self.registry)
        self.task = find_task(self.registry, plan.task)
        self.world: World = make_world(plan.world, self.registry, arm=plan.arm)

    def instance(self, number: int) -> Instance:
        """Return an instance drawn from the seed, with a goal that is not excluded."""
        for attempt in range(REDRAWS):
            rng = np.random.default_rng((self.plan.seed, number, attempt))
            drawn = draw(self.registry, self.task, rng, dict(self.plan.varied))
            if end_configuration(drawn.goal) not in self.plan.excluded and self._is_left(drawn, number):
                return drawn
        raise NtpError(f"all {REDRAWS} goals that were drawn are excluded, or hold at the start")

    def _is_left(self, instance: Instance, number: int) -> bool:
        """Return whether there is anything to demonstrate."""
        start = demonstration_start(self.registry, instance, derived(self.plan.seed, number))
        return not instance.holds_in(self.registry, start)

    def record(self, number: int) -> RecordedEpisode:
        """Record an episode's two files; a failed one leaves only its row of the manifest."""
        instance = self.instance(number)
        seed = derived(self.plan.seed, number)
        row = partial(RecordedEpisode, number=number, seed=seed, goal=instance.goal)
        shown = demonstrate(self.registry, self.expert, self.world, instance, seed)
        if not isinstance(shown, RecordedDemonstration):
            return row(outcome=Recorded.NO_DEMONSTRATION, reason=str(shown))
        trace, shown_in = episode_files(self.plan.out, number)
        try:
            with written_whole(trace) as unfinished, unfinished.open("w", encoding="utf-8") as stream:
                run = record_episode(
                    self.registry,
                    self.expert,
                    self.world,
                    instance,
                    shown,
                    seed,
                    TraceWriter(stream),
                    self.plan.perturbation_rate,
                    shown_in.name,
                )
                if not run.done:
                    raise EpisodeFailed(str(run))
        except (EpisodeFailed, OutOfRange) as failure:
            return row(outcome=Recorded.EPISODE_FAILED, reason=str(failure))
        write_demonstration(shown.demonstration, shown_in)
        if self.plan.say and shown.calls is not None:
            said = "".join(f"{sentence}\n" for sentence in in_words(self.registry, shown.calls))
            with written_whole(sentences_file(self.plan.out, number)) as unfinished:
                unfinished.write_text(said, encoding="utf-8")
        frames = len(shown.demonstration)
        return row(outcome=Recorded.DONE, frames=frames, primitives=run.primitives)


class EpisodeFailed(Exception):
    """An episode that is not kept; its reason goes into the manifest."""


def record(plan: RecordingPlan, episodes: int, workers: int) -> Iterator[RecordedEpisode]:
    """Yield the manifest's rows, in order, whatever the number of workers.

    An earlier recording in the folder is replaced, and nothing else. The manifest comes last, also where the
    recording is interrupted: what it names is whole.

    Raises `NtpError`, before anything is deleted, where nothing could be recorded, where another process
    records into the folder, or where it holds other files.
    """
    EpisodeRecorder(plan).instance(0)  # whatever is wrong with the plan shows here
    try:
        with locked(plan.out):
            clear(plan.out, plan.overwrite)
            yield from _recorded(plan, episodes, workers)
    except BlockingIOError as error:
        raise NtpError(f"{plan.out}: another process is recording into this folder") from error


def _recorded(plan: RecordingPlan, episodes: int, workers: int) -> Iterator[RecordedEpisode]:
    rows: list[RecordedEpisode] = []
    try:
        for row in in_order(partial(_open, plan), episodes, workers):
            rows.append(row)
            yield row
    finally:
        if rows:
            _write_manifest(plan, rows, episodes)


def clear(folder: Path, overwrite: bool) -> None:
    """Delete an earlier recording, by its manifest, and what a killed one left unfinished.

    Args:
        overwrite: deletes episodes that no manifest names, too, and lets other files be.

    Raises `NtpError`, and deletes nothing, for a folder with other files that may not be overwritten.
    """
    ours = recorded_files(folder)
    kinds = (".episode_*.partial", f".{MANIFEST}.*.partial")
    unfinished = {path.name for kind in kinds for path in folder.glob(kind)}
    others = {path.name for path in folder.iterdir()} - ours - unfinished - {LOCK}
    if others and not overwrite:
        listed = ", ".join(sorted(others)[:3]) + (", ..." if len(others) > 3 else "")
        raise NtpError(
            f"{folder} holds files that no recording's manifest names ({listed}): choose another folder, or "
            "replace earlier episodes with --overwrite"
        )
    episodes = {name for name in others if EPISODE_FILE.fullmatch(name)}
    for name in ours | unfinished | episodes:
        (folder / name).unlink(missing_ok=True)


def _write_manifest(plan: RecordingPlan, rows: list[RecordedEpisode], wanted: int) -> None:
    registry = load_with_python(plan.library)
    manifest = Manifest(
        format=FORMAT,
        version=VERSION,
        library=registry.name,
        registry=registry.hash,
        task=plan.task,
        episodes=tuple(rows),
        wanted=wanted,
        world=plan.world,
        arm=plan.arm,
        seed=plan.seed,
        perturbation_rate=plan.perturbation_rate,
        command=plan.command,
        said=plan.say,
        excluded=len(plan.excluded),
        excluded_files=dict(plan.excluded_files),
        varied=dict(plan.varied),
        versions={name: version(name) for name in ("ntp_dsl", "numpy")},
    )
    write_manifest(manifest, plan.out)


def _open(plan: RecordingPlan) -> Callable[[int], RecordedEpisode]:
    return EpisodeRecorder(plan).record


def samples(
    registry: Registry, folder: Path, manifest: Manifest, seed: int, config: LabelConfig = LABELS
) -> Iterator[list[Sample]]:
    """Yield the labelled queries of each episode that was kept."""
    expert = Expert(registry)
    task = find_task(registry, manifest.task)
    kept = [row for row in manifest.episodes if row.is_kept]
    more = min(config.new_states_of_episode, config.new_states // max(1, len(kept)))
    for row in kept:
        path, shown_in = episode_files(folder, row.number)
        trace = read_trace(path)
        if trace.end is None:
            raise NtpError(f"{path}: was cut off; record anew")
        demonstration = read_demonstration(shown_in)
        if trace.header.demonstration is None or trace.header.demonstration.calls is None:
            raise NtpError(f"{path}: does not say what its demonstration shows; record anew")
        shown = trace.header.demonstration.calls
        rng = np.random.default_rng((seed, row.number))
        new_states = _new_states(registry, task, more, rng)
        yield list(labelled(config, expert, demonstration, shown, trace, new_states, rng))


def _new_states(
    registry: Registry, task: TaskDeclaration, count: int, rng: np.random.Generator
) -> Iterator[Observation]:
    """Yield perturbed starts of the task's scenes: an expert can decide in any state."""
    world = make_world("kinematic", registry)
    for _ in range(count):
        scene = draw(registry, task, rng).perturbed_start(rng, world.starts_holding)
        world.reset(scene, int(rng.integers(2**31)))
        yield world.truth()
