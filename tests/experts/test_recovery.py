"""From wherever it starts, the expert arrives."""

from __future__ import annotations

import pytest
from expert_samples import experts, run_from_anywhere

from ntp_dsl.language.registry import Registry
from ntp_dsl.worlds.protocol import Disturbances

STARTS, SOAKED, SHARDS = 150, 2000, 5


@pytest.mark.parametrize("shard", range(SHARDS))
@pytest.mark.parametrize("slips", [0.0, 0.25])
@pytest.mark.parametrize("kind", ["declared", "in Python"])
def test_the_goal_is_reached_from_any_perturbed_start(
    stacking: Registry, soak: bool, kind: str, slips: float, shard: int
) -> None:
    expert = experts(stacking)[kind]
    for seed in range(shard, SOAKED if soak else STARTS, SHARDS):
        run, reached = run_from_anywhere(expert, seed, Disturbances(slips=slips))
        assert run.done and reached, f"seed {seed}: {run.reason}"


@pytest.mark.parametrize("shard", range(SHARDS))
def test_towers_that_are_pushed_over_are_built_again(stacking: Registry, soak: bool, shard: int) -> None:
    """A tower of five is pushed three times of four before it is up, so that this takes long."""
    expert = experts(stacking)["declared"]
    for seed in range(shard, SOAKED if soak else STARTS // 5, SHARDS):
        disturbances = Disturbances(slips=0.25, pushes=0.25)
        run, reached = run_from_anywhere(expert, seed, disturbances, primitives=3000)
        assert run.done and reached, f"seed {seed}: {run.reason}"
