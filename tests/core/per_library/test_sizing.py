"""A core points at one object more where what is carried has something in it."""

from __future__ import annotations

import numpy as np
import pytest

from ntp_dsl.core.per_library.config import CoreConfig
from ntp_dsl.core.per_library.memory import Memory
from ntp_dsl.core.per_library.sizing import carries_a_load, sized
from ntp_dsl.datasets.recording import RecordedDemonstration, demonstrate
from ntp_dsl.demonstrations.demonstration import Demonstration
from ntp_dsl.language.registry import Registry
from ntp_dsl.policies.expert import Expert
from ntp_dsl.tasks.instances import draw, find_task
from ntp_dsl.user_code.loading import load_with_python
from ntp_dsl.worlds.catalogue import make_world


def shown(registry: Registry, world: str, seed: int = 0) -> Demonstration:
    instance = draw(registry, find_task(registry, registry.name), np.random.default_rng(seed))
    demonstration = demonstrate(registry, Expert(registry), make_world(world, registry), instance, seed)
    assert isinstance(demonstration, RecordedDemonstration)
    return demonstration.demonstration


@pytest.mark.parametrize("world", ["kinematic", "bullet"])
@pytest.mark.parametrize(
    "example, hops", [("table_cleanup", 3), ("block_stacking", 2), ("object_sorting", 2)]
)
def test_bowls_take_forks_along_and_blocks_nothing(example: str, hops: int, world: str) -> None:
    registry = load_with_python(example)
    assert sized(Memory.of(registry), [shown(registry, world)]) == CoreConfig(hops=hops)


def test_a_load_is_noticed_whatever_else_there_is_and_in_whatever_order() -> None:
    registry = load_with_python("table_cleanup")
    demonstration = shown(registry, "kinematic")
    positions, closed = demonstration.relative, demonstration.closed
    order = np.random.default_rng(0).permutation(positions.shape[1])
    table = [obj.name for obj in demonstration.objects].index("table")
    distractors = np.repeat(positions[:, table : table + 1], 3, axis=1) + 0.1
    assert carries_a_load(positions, closed)
    assert carries_a_load(positions[:, order], closed)
    assert carries_a_load(np.concatenate([positions, distractors], axis=1), closed)
    assert not carries_a_load(positions, np.zeros_like(closed)), "an empty hand takes nothing along"


@pytest.mark.parametrize("along", [1, 2, 3, 4])
@pytest.mark.parametrize("still", [1, 2, 5])
def test_a_load_is_noticed_however_many_go_along(along: int, still: int) -> None:
    ways = 0.02 * np.arange(8)[:, None, None] * np.array([1.0, 0.0, 0.0])
    positions = np.concatenate([np.zeros((8, along, 3)), 0.3 - ways.repeat(still, axis=1)], axis=1)
    assert carries_a_load(positions.astype(np.float32), np.ones(8, bool)) == (along > 1)
