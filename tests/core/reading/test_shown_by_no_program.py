"""Demonstrations that no program made: by detours, all laid aside first, and in an order of its own."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest
from one_core_samples import library, lists, read

from ntp_dsl.api import Task, draw
from ntp_dsl.datasets.recording import demonstration_start
from ntp_dsl.demonstrations.demonstration import Demonstration, Recorder, noisy
from ntp_dsl.worlds.kinematic import KinematicWorld

SEEDS = range(3)


def placements(task: Task) -> list[tuple[str, str]]:
    """Return which object goes where, in the order of the goal."""
    found = []
    for row in task.goal:
        first, where = [value for _, value in row.fields if isinstance(value, str)][:2]
        traits = [each.name for each in task.instance.objects if first in dict(each.traits).values()]
        found += [(name, where) for name in traits or [first]]
    return found


def shown(task: Task, seed: int, hand: str) -> Demonstration:
    """Return what a hand does that knows the goal and no program."""
    rng = np.random.default_rng(seed)
    world = KinematicWorld()
    world.reset(demonstration_start(task.registry, task.instance, seed), seed)
    recorder = Recorder(world)
    order = placements(task)
    if hand == "in its own order":
        order = [order[index] for index in rng.permutation(len(order))]
    if hand == "all aside first":
        order = [*((item, "table") for item, _ in order), *order]
    for item, where in order:
        by_way = hand == "by detours" and rng.random() < 0.5
        carry(world, item, ["table", where] if by_way else [where])
    return noisy(recorder.demonstration(), 0.003, rng)


def carry(world: KinematicWorld, item: str, places: Sequence[str]) -> None:
    for place in places:
        for api, arguments in (
            ("move_to", (item,)),
            ("grasp", (item,)),
            ("move_to", (place,)),
            ("release", ()),
        ):
            assert world.call(api, arguments).achieved, (api, arguments)


HANDS = ("by detours", "all aside first", "in its own order")
SHOWN = [
    *(("block_stacking", hand) for hand in HANDS[:2]),  # towers are built from below
    *((name, hand) for name in ("seating", "object_sorting") for hand in HANDS),
]


@pytest.mark.parametrize("name, hand", SHOWN)
def test_the_lists_are_read(name: str, hand: str) -> None:
    for seed in SEEDS:
        task = draw(library(name), name, seed)
        found = read(task, shown(task, seed, hand))
        assert sorted(lists(found.arguments)[0]) == sorted(lists(task.instance.arguments)[0])
        assert not found.strays
