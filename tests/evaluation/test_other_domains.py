"""Other domains: relations of three objects, numeric offsets, exchanges, objects in the way."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from ntp_dsl.common.resources import examples_folder
from ntp_dsl.core.one_core import shipped_core
from ntp_dsl.evaluation.episodes import Plan, run_all
from ntp_dsl.language.loader import load
from ntp_dsl.worlds.protocol import Disturbances

FOLDER = Path(__file__).parent / "domains"
LARGE = {"crowded", "four_and_twenty"}
SLOW = {"many_objects", "four_and_twelve", "twenty_objects", "trading"}  # once; by the arm for `--soak`
DOMAINS = sorted(path.name for path in FOLDER.iterdir())


@pytest.mark.parametrize("world, count", [("kinematic", 20), ("bullet", 1)])
@pytest.mark.parametrize("domain", DOMAINS)
def test_its_expert_succeeds_although_objects_slip(domain: str, world: str, count: int) -> None:
    plan = Plan(FOLDER / domain, domain, None, world, seed=1, disturbances=Disturbances(slips=0.15))
    failed = [(each.number, each.reason) for each in run_all(plan, count, workers=1) if not each.success]
    assert not failed


def tasks() -> list[Any]:
    folders = [*examples_folder().iterdir(), *FOLDER.iterdir()]
    found = [(each, task) for each in sorted(folders) if each.is_dir() for task in load(each).tasks]
    return [pytest.param(*each, marks=[pytest.mark.minutes] * (each[1] in LARGE)) for each in found]


def for_the_arm() -> list[Any]:
    """Return all tasks but those that are too crowded for fingers."""
    found = [each.values for each in tasks() if each.values[1] not in LARGE]
    return [pytest.param(*each, marks=[pytest.mark.minutes] * (each[1] in SLOW)) for each in found]


@pytest.mark.parametrize("library, task", tasks(), ids=lambda value: getattr(value, "name", value))
def test_a_task_is_done_from_one_demonstration_without_training(library: Path, task: str, soak: bool) -> None:
    count = 100 if soak and task not in LARGE else 1 if task in SLOW else 3
    plan = Plan(library, task, shipped_core(), seed=5)
    assert sum(bool(each.success) for each in run_all(plan, count, workers=1)) >= 0.95 * count


@pytest.mark.parametrize("library, task", for_the_arm(), ids=lambda value: getattr(value, "name", value))
def test_the_arm_does_a_task_from_its_own_demonstration(library: Path, task: str, soak: bool) -> None:
    """The arm grasps at other heights than the kinematic hand, and to fractions of a millimetre."""
    count = 10 if soak else 1
    plan = Plan(library, task, shipped_core(), "bullet", seed=22)
    assert sum(bool(each.success) for each in run_all(plan, count, workers=1)) >= 0.8 * count


@pytest.mark.parametrize("task", ["block_stacking", "seating", "table_cleanup", "object_sorting"])
def test_noise_of_twelve_millimetres_is_seen_through(task: str, soak: bool) -> None:
    count = 100 if soak else 3
    plan = Plan(Path(task), task, shipped_core(), seed=5, disturbances=Disturbances(noise=0.012))
    assert sum(bool(each.success) for each in run_all(plan, count, workers=1)) >= 0.95 * count
