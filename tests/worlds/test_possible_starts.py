"""Every start of every task is possible: no two objects overlap, and nothing hangs in the air."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from start_rules import faults

from ntp_dsl.common.resources import examples_folder
from ntp_dsl.dynamic.starts import STARTS
from ntp_dsl.language.registry import Registry
from ntp_dsl.semantics.observation import TOO_WIDE
from ntp_dsl.tasks.instances import draw
from ntp_dsl.user_code.loading import load_with_python
from ntp_dsl.worlds.kinematic import KinematicWorld

SEEDS, SOAKED, MANY_OBJECTS = 5, 200, 30
DOMAINS = Path(__file__).parents[1] / "evaluation" / "domains"
LIBRARIES = sorted([*examples_folder().glob("*/*.ntp"), *DOMAINS.glob("*/*.ntp")])
STACKED = """
library mine
use containers

type Pad is Place
type Low is Movable
type High is Movable
type Bowl is Movable

program fill(goal: list[Placement]):
    achieves all on(p.item, p.support) for p in goal
    for p in goal:
        pick_and_place(p.item, p.support)

task filling:
    scene: {scene}
    goal:    matchings(lows, pads, pairs=1)
    run:     fill(goal)
    success: all on(p.item, p.support) for p in goal
"""
SCENES = {
    "lows on pads": """
        pads: 3 Pad on table with box(9 cm, 9 cm, 1 cm)
        lows: 2 Low on pads""",
    "highs on lows": """
        pads: 3 Pad on table with box(9 cm, 9 cm, 1 cm)
        lows: 2 Low on pads
        highs: 2 High on lows""",
    "wide ones on small pads": """
        pads: 3 Pad on table with box(5 cm, 5 cm, 1 cm)
        lows: 3 Low on pads with box(12 cm, 6 cm, 3 cm)""",
    "a full tray": """
        pads: 1 Pad on table with box(20 cm, 14 cm, 1 cm)
        lows: 6 Low on pads with box(5 cm, 4 cm, 3 cm)""",
    "bins": """
        pads: 2 Pad on table with bin(21 cm, 21 cm, 8 cm), at(40 cm, 40 cm, 40 cm, -40 cm)
        lows: 12 Low on pads with box(5 cm, 3 cm, 3 cm)""",
    "bowls with something in them": """
        pads: 2 Pad on table with box(10 cm, 10 cm, 2 cm)
        bowls: 3 Bowl on table with bowl(14 cm, 6 cm), x(0.3 .. 0.75 m), y(-0.4 .. 0.4 m)
        lows: 3 Low on bowls with cube(3 cm)
        highs: 2 High on lows with cube(2 cm)""",
    "planks across pillars": """
        pads: 2 Pad on table with cube(4 cm), at(40 cm, 0 cm, 60 cm, 0 cm)
        lows: 3 Low on table with box(4 cm, 18 cm, 2 cm)
        highs: 3 High on table with box(16 cm, 3 cm, 12 cm), y(-0.4 .. 0.4 m)""",
}


def impossible(registry: Registry, seeds: int) -> list[str]:
    found: list[str] = []
    for task in registry.tasks.values():
        count = len(draw(registry, task, np.random.default_rng(0)).objects)
        for seed in range(seeds if count < MANY_OBJECTS else max(1, seeds // 10)):
            for kind, (start, _) in STARTS.items():
                rng = np.random.default_rng(seed)
                scene = start(draw(registry, task, rng), rng)
                found += [f"{task.name}, {kind}, seed {seed}: {fault}" for fault in faults(scene)]
    return found


@pytest.mark.parametrize("path", LIBRARIES, ids=lambda path: path.stem)
def test_every_start_of_a_shipped_task_is_possible(path: Path, soak: bool) -> None:
    assert impossible(load_with_python(path), SOAKED if soak else SEEDS) == []


def registry_of(folder: Path, scene: str) -> Registry:
    path = folder / "mine.ntp"
    path.write_text(STACKED.format(scene=scene))
    return load_with_python(path)


@pytest.mark.parametrize("scene", SCENES)
def test_every_start_of_objects_on_others_is_possible(tmp_path: Path, scene: str, soak: bool) -> None:
    assert impossible(registry_of(tmp_path, SCENES[scene]), SOAKED if soak else 20) == []


@pytest.mark.parametrize("scene", SCENES)
def test_nothing_falls_by_itself(tmp_path: Path, scene: str) -> None:
    """The kinematic world's own rules of resting agree."""
    registry = registry_of(tmp_path, SCENES[scene])
    (task,) = registry.tasks.values()
    for seed in range(20):
        for start, _ in STARTS.values():
            rng = np.random.default_rng(seed)
            world = KinematicWorld()
            world.reset(start(draw(registry, task, rng), rng), seed)
            world._drop_unsupported()
            assert world.disturbed == set()


def test_who_starts_on_whom_is_drawn_by_the_seed(tmp_path: Path) -> None:
    registry = registry_of(tmp_path, SCENES["highs on lows"])
    (task,) = registry.tasks.values()

    def supports(seed: int) -> tuple[str, ...]:
        starts = draw(registry, task, np.random.default_rng(seed)).starts
        return tuple(starts[name].surface for name in ("low_0", "low_1", "high_0", "high_1"))

    drawn = [supports(seed) for seed in range(100)]
    assert drawn == [supports(seed) for seed in range(100)]
    assert len(set(drawn)) == 12, "two lows on three pads, and two highs on two lows"
    assert all(len(set(each)) == 4 for each in drawn), "none shares its place"


def test_a_perturbed_start_differs_from_the_nominal_one_in_what_is_on_what(tmp_path: Path) -> None:
    registry = registry_of(tmp_path, SCENES["highs on lows"])
    (task,) = registry.tasks.values()
    stays = 0
    for seed in range(100):
        instance = draw(registry, task, np.random.default_rng(seed))
        nominal = instance.nominal_start(np.random.default_rng(seed)).positions
        perturbed = instance.perturbed_start(np.random.default_rng(seed)).positions
        stays += nominal == perturbed
    assert stays < 30


def test_all_objects_have_a_position(tmp_path: Path) -> None:
    for scene in SCENES.values():
        registry = registry_of(tmp_path, scene)
        (task,) = registry.tasks.values()
        for kind, (start, _) in STARTS.items():
            drawn = start(draw(registry, task, np.random.default_rng(1)), np.random.default_rng(1))
            names = {obj.name for obj in drawn.objects if obj.size[0] <= TOO_WIDE}
            assert len(names - drawn.positions.keys()) == (kind == "missing object")
