"""Labels for training: what is asked about, and in which company."""

from __future__ import annotations

from math import dist
from pathlib import Path

import numpy as np

from ntp_dsl.datasets.dataset import RecordingPlan, record, samples
from ntp_dsl.datasets.labels import ASIDE, DISTRACTOR, LabelConfig, with_distractor
from ntp_dsl.datasets.manifest import read_manifest
from ntp_dsl.language.loader import load
from ntp_dsl.policies.expert import Expert, NextCall
from ntp_dsl.policies.random_arguments import random_arguments
from ntp_dsl.semantics.state import State
from ntp_dsl.tasks.instances import draw, find_task
from ntp_dsl.worlds.kinematic import KinematicWorld

CONFIG = LabelConfig()


def test_a_bystander_stands_apart_and_is_of_no_account() -> None:
    registry = load("block_stacking")
    expert, world = Expert(registry), KinematicWorld()
    for seed in range(20):
        rng = np.random.default_rng(seed)
        instance = draw(registry, find_task(registry, "block_stacking"), rng)
        world.reset(instance.perturbed_start(rng), seed)
        alone = world.truth()
        joined = with_distractor(alone, rng)
        assert [obj.name for obj in joined.objects] == [*(t.name for t in alone.objects), DISTRACTOR]
        place = joined.positions[DISTRACTOR]
        others = [p for name, p in alone.positions.items() if name != "table"]
        assert min(dist(place[:2], other[:2]) for other in others) > ASIDE
        for program in (p for p in registry.programs.values() if not p.takes_list):
            arguments = random_arguments(program.parameters, State(registry, alone), rng)
            assert arguments is not None
            decisions = [expert.decide(program.name, arguments, State(registry, o)) for o in (alone, joined)]
            assert decisions[0] == decisions[1]


def test_queries_are_also_about_scenes_that_no_episode_went_through(tmp_path: Path) -> None:
    registry = load("block_stacking")
    plan = RecordingPlan(Path("block_stacking"), "few_placements", tmp_path)
    assert [row.outcome for row in record(plan, 2, workers=1)] == ["done"] * 2
    manifest = read_manifest(tmp_path, registry)
    first, again = ([*samples(registry, tmp_path, manifest, 5)] for _ in range(2))
    told = [[(s.query.observation, s.answer) for episode in each for s in episode] for each in (first, again)]
    assert told[0] == told[1]
    expert = Expert(registry)
    for episode in first:
        count = CONFIG.new_states_of_episode * CONFIG.off_stack_of_new
        old, new = episode[:-count], episode[-count:]
        places = [{tuple(s.query.observation.positions["block_0"]) for s in each} for each in (old, new)]
        assert len(places[1]) == CONFIG.new_states_of_episode and not places[0] & places[1]
        for sample in new:
            query, answer = sample.query, sample.answer
            assert query.scope is None and answer.scope is None
            decision = expert.decide(query.program, query.arguments, State(registry, query.observation))
            assert answer.callee == (decision.callee if isinstance(decision, NextCall) else None)
