"""Training learns, repeats itself for a seed, and goes on where it was interrupted."""

from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np
import pytest
import torch

from ntp_dsl.core.per_library.checkpoint import resume_training, save_training
from ntp_dsl.core.per_library.config import CoreConfig, TrainingConfig
from ntp_dsl.core.per_library.corpus import Corpus
from ntp_dsl.core.per_library.memory import Memory
from ntp_dsl.core.per_library.training import Trainer
from ntp_dsl.datasets.dataset import RecordingPlan, record, samples
from ntp_dsl.datasets.manifest import read_manifest
from ntp_dsl.language.diagnostics.diagnostics import NtpError
from ntp_dsl.language.loader import load
from ntp_dsl.language.registry import Registry

CONFIG = TrainingConfig(iterations=60, demonstrations=3, queries_per_demonstration=6)


@pytest.fixture(scope="session")
def corpus(stacking: Registry, tmp_path_factory: pytest.TempPathFactory) -> Corpus:
    folder = tmp_path_factory.mktemp("data")
    plan = RecordingPlan(Path("block_stacking"), "few_placements", folder)
    rows = list(record(plan, 5, workers=1))
    assert [row.outcome for row in rows] == ["done"] * 5
    manifest = read_manifest(folder, stacking)
    labelled = [s for episode in samples(stacking, folder, manifest, 0) for s in episode]
    takes_list = {name: program.takes_list for name, program in stacking.programs.items()}
    return Corpus(Memory.of(stacking), labelled, takes_list.__getitem__)


def trained(corpus: Corpus, iterations: int) -> Trainer:
    trainer = Trainer(CoreConfig(), CONFIG, corpus.memory)
    while trainer.iteration < iterations:
        trainer.step(corpus)
        trainer.iteration += 1
    return trainer


def equal(one: Trainer, other: Trainer) -> bool:
    theirs = other.core.state_dict()
    return all(torch.equal(mine, theirs[name]) for name, mine in one.core.state_dict().items())


def test_the_loss_goes_down(corpus: Corpus) -> None:
    losses: list[float] = []
    trainer = Trainer(CoreConfig(), CONFIG, corpus.memory)
    trainer.run(corpus, lambda _, parts: losses.append(sum(parts.values())))
    assert sum(losses[-5:]) < 0.5 * sum(losses[:5])


def test_the_same_seed_trains_the_same_core(corpus: Corpus) -> None:
    assert equal(trained(corpus, 3), trained(corpus, 3))


def test_a_training_that_was_interrupted_ends_where_it_would_have(corpus: Corpus, tmp_path: Path) -> None:
    path = tmp_path / "training.safetensors"
    save_training(trained(corpus, 3), path)
    resumed = Trainer(CoreConfig(), CONFIG, corpus.memory)
    resume_training(resumed, path)
    assert resumed.iteration == 3
    for _ in range(2):
        resumed.step(corpus)
        resumed.iteration += 1
    assert equal(resumed, trained(corpus, 5))


def test_a_training_with_other_settings_is_not_gone_on_with(corpus: Corpus, tmp_path: Path) -> None:
    path = tmp_path / "training.safetensors"
    save_training(trained(corpus, 1), path)
    other = Trainer(CoreConfig(), TrainingConfig(seed=1), corpus.memory)
    with pytest.raises(NtpError, match="other settings"):
        resume_training(other, path)


def test_recordings_do_not_depend_on_the_number_of_workers(tmp_path: Path) -> None:
    folders = []
    for workers in (1, 2):
        folder = tmp_path / str(workers)
        plan = RecordingPlan(Path("block_stacking"), "few_placements", folder, seed=3)
        assert len(list(record(plan, 3, workers))) == 3
        folders.append(folder)
    for file in sorted(folders[0].glob("*.jsonl")):
        one, other = (re.sub(r'"seconds":[^,}]*', "", (f / file.name).read_text()) for f in folders)
        assert one == other


def test_data_of_another_library_are_refused(stacking: Registry, tmp_path: Path) -> None:
    facts = {"registry": "x", "library": "y", "task": "z", "episodes": []}
    (tmp_path / "manifest.json").write_text(json.dumps({"format": "ntp-dataset", "version": 1, **facts}))
    with pytest.raises(NtpError, match="another library"):
        read_manifest(tmp_path, stacking)
    with pytest.raises(NtpError, match="ntp record"):
        read_manifest(tmp_path / "none", stacking)


PILE = """library mine
use tabletop
program pile(a: Movable, b: Movable, c: Movable, d: Movable):
    requires (
        present(a) and reachable(a) and present(b) and reachable(b)
        and present(c) and reachable(c) and present(d) and reachable(d)
    )
    achieves on(b, a) and on(c, b) and on(d, c)
    pick_and_place(b, a)
    pick_and_place(c, b)
    pick_and_place(d, c)
"""


def test_there_is_a_pointer_for_each_object_that_a_call_takes(stacking: Registry, tmp_path: Path) -> None:
    path = tmp_path / "mine.ntp"
    path.write_text(PILE)
    for registry, hops in ((stacking, 2), (load(path), 4)):
        core = Trainer(CoreConfig(), CONFIG, Memory.of(registry)).core
        assert len(core.reader.hops) == hops


LISTS = """library mine
use tabletop
program build(goal: list[Placement]):
    achieves all on(p.item, p.support) for p in goal
    build_again(goal)
program build_again(goal: list[Placement]):
    achieves all on(p.item, p.support) for p in goal
    for p in goal:
        pick_and_place(p.item, p.support)
program take_down():
    achieves all clear(b) for b in Block
    for b in Block:
        clear(b)
task nested:
    scene: blocks: 4 Block on table
    goal: towers(blocks, placements=1..2, height=2..2)
    run: build(goal)
    success: all on(p.item, p.support) for p in goal
task plain:
    scene:
        lower: 2 Block on table
        upper: 2 Block on lower
    goal: matchings(lower, upper, pairs=1..2) -> list[Placement]
    run: take_down()
    success: all clear(b) for b in Block
"""


@pytest.mark.parametrize(("task", "lists"), [("nested", 1), ("plain", 0)])
def test_queries_share_a_reading_only_with_their_like(task: str, lists: int, tmp_path: Path) -> None:
    path = tmp_path / "mine.ntp"
    path.write_text(LISTS)
    registry = load(path)
    plan = RecordingPlan(path, task, tmp_path / "data")
    assert [row.outcome for row in record(plan, 4, workers=1)] == ["done"] * 4
    manifest = read_manifest(plan.out, registry)
    labelled = [s for episode in samples(registry, plan.out, manifest, 0) for s in episode]
    corpus = Corpus(Memory.of(registry), labelled, lambda name: registry.programs[name].takes_list)
    for seed in range(10):
        drawn = corpus.batches(CONFIG, 2, np.random.default_rng(seed))
        assert len(drawn) == lists + 2  # and with parts, and without
        for frames, states, _ in drawn:
            if frames is not None:
                assert torch.equal(frames.rows[states.spec], states.rows)
    assert trained(corpus, 2).iteration == 2
