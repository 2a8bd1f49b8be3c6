"""A program may take a record: the core gives its fields, and the call is made with the record."""

from __future__ import annotations

import json
from dataclasses import asdict
from pathlib import Path

import numpy as np
import pytest

from ntp_dsl.common.decoding import decode
from ntp_dsl.core.per_library.config import CoreConfig, TrainingConfig
from ntp_dsl.core.per_library.corpus import Corpus
from ntp_dsl.core.per_library.memory import Memory
from ntp_dsl.core.per_library.policy import LearnedPolicy
from ntp_dsl.core.per_library.training import Trainer
from ntp_dsl.datasets.dataset import RecordingPlan, record, samples
from ntp_dsl.datasets.manifest import read_manifest
from ntp_dsl.demonstrations.demonstration_files import read_demonstration
from ntp_dsl.language.loader import load
from ntp_dsl.language.registry import Registry
from ntp_dsl.policies.protocol import Frame
from ntp_dsl.policies.random_arguments import random_arguments
from ntp_dsl.semantics.observation import Record, without_lists
from ntp_dsl.semantics.state import State
from ntp_dsl.tasks.instances import draw, find_task
from ntp_dsl.worlds.kinematic import KinematicWorld

END = frozenset({None})  # is barred, so that a call is made
LIBRARY = """library mine
use tabletop
enum Side: left, right
record Turn(side: Side, item: Movable, angle: number in 0 .. 6)

program stack_all(goal: list[Placement]):
    achieves all on(p.item, p.support) for p in goal
    for p in goal:
        stack(p)

program stack(p: Placement):
    requires present(p.item) and reachable(p.item) and present(p.support) and reachable(p.support)
    achieves on(p.item, p.support)
    pick_and_place(p.item, p.support)

program turned(first: Movable, turn: Turn, side: Side):
    requires present(first) and present(turn.item) and reachable(turn.item)
    achieves holding(turn.item)
    pick(turn.item)

task mine:
    scene: blocks: 4 Block on table with cube(5 cm)
    goal: towers(blocks, placements=1..2, height=2..3)
    run: stack_all(goal)
    success: all on(p.item, p.support) for p in goal
"""


@pytest.fixture
def registry(tmp_path: Path) -> Registry:
    path = tmp_path / "mine.ntp"
    path.write_text(LIBRARY)
    return load(path)


def test_arguments_survive_being_taken_apart_and_put_together(registry: Registry) -> None:
    rng = np.random.default_rng(0)
    world, memory = KinematicWorld(), Memory.of(registry)
    instance = draw(registry, find_task(registry, "mine"), rng)
    world.reset(instance.perturbed_start(rng), 0)
    for name, count in (("stack", 2), ("turned", 5), ("pick", 1)):
        arguments = random_arguments(registry[name].parameters, State(registry, world.truth()), rng)
        assert arguments is not None
        flat = without_lists(arguments)
        assert len(flat) == count
        signature = memory.signature(name)
        assert signature.packed(signature.join(*signature.split(flat))) == arguments
        assert decode(json.dumps(asdict(memory)), Memory) == memory


WITHOUT_MEMBERS = LIBRARY.replace("enum Side: left, right\n", "").replace("Side", "Movable")


@pytest.mark.parametrize("text", [LIBRARY, WITHOUT_MEMBERS], ids=["with members", "without"])
def test_a_core_calls_with_records(text: str, tmp_path: Path) -> None:
    (tmp_path / "mine.ntp").write_text(text)
    registry = load(tmp_path / "mine.ntp")
    rows = list(record(RecordingPlan(tmp_path / "mine.ntp", "mine", tmp_path / "data"), 3, workers=1))
    assert [row.outcome for row in rows] == ["done"] * 3
    labelled = [
        s
        for episode in samples(registry, tmp_path / "data", read_manifest(tmp_path / "data", registry), 0)
        for s in episode
    ]
    assert any(sample.query.program == "stack" and sample.query.scope for sample in labelled)
    corpus = Corpus(Memory.of(registry), labelled, lambda name: registry.programs[name].takes_list)
    config = TrainingConfig(iterations=5, demonstrations=3, queries_per_demonstration=6)
    core = Trainer(CoreConfig(), config, corpus.memory).run(corpus)
    rng = np.random.default_rng(1)
    instance = draw(registry, find_task(registry, "mine"), rng)
    world = KinematicWorld()
    world.reset(instance.nominal_start(rng), 1)
    policy = LearnedPolicy(core, read_demonstration(tmp_path / "data" / "episode_00000.demo.parquet"))
    call = policy.decide(policy.root(instance.program, ()), world, END)
    assert call.callee == "stack" and isinstance(call.arguments[0], Record)
    item, support = (value for _, value in call.arguments[0].fields)
    inner = policy.decide(Frame("stack", call.arguments, call.scope), world, END)
    assert inner.callee == "pick_and_place"
    assert {item, support} <= world.truth().positions.keys()
