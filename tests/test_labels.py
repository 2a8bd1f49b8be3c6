"""Labels for training: what is asked about, and in which company."""

from __future__ import annotations

from math import dist

import numpy as np

from ntp_dsl.experts import Expert
from ntp_dsl.labels import ASIDE, NAMED, with_bystander
from ntp_dsl.language.loader import load
from ntp_dsl.random_arguments import random_arguments
from ntp_dsl.state import State
from ntp_dsl.tasks import draw, find_task
from ntp_dsl.worlds.kinematic import KinematicWorld


def test_a_bystander_stands_apart_and_is_of_no_account() -> None:
    registry = load("block_stacking")
    expert, world = Expert(registry), KinematicWorld()
    for seed in range(20):
        rng = np.random.default_rng(seed)
        instance = draw(registry, find_task(registry, "block_stacking"), rng)
        world.reset(instance.scrambled(rng), seed)
        alone = world.truth()
        joined = with_bystander(alone, rng)
        assert [thing.name for thing in joined.things] == [*(t.name for t in alone.things), NAMED]
        place = joined.positions[NAMED]
        others = [p for name, p in alone.positions.items() if name != "table"]
        assert min(dist(place[:2], other[:2]) for other in others) > ASIDE
        for program in (p for p in registry.programs.values() if not p.takes_list):
            arguments = random_arguments(program.parameters, State(registry, alone), rng)
            assert arguments is not None
            decisions = [expert.decide(program.name, arguments, State(registry, o)) for o in (alone, joined)]
            assert decisions[0] == decisions[1]
