"""One-shot imitation in both worlds, and its statistics."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from ntp_dsl.common.proportions import wilson
from ntp_dsl.common.resources import checkpoints_folder
from ntp_dsl.evaluation.episodes import Episode, Plan, run_all
from ntp_dsl.evaluation.statistics import statistics
from ntp_dsl.language.diagnostics.diagnostics import NtpError
from ntp_dsl.traces.schema import Attribution
from ntp_dsl.worlds.protocol import Disturbances

STACKING = Plan(Path("block_stacking"), "block_stacking", checkpoints_folder() / "core.safetensors")
SCRIPTED = replace(STACKING, model=None)


@pytest.fixture(scope="module")
def count(soak: bool) -> int:
    """Return the number of episodes of a figure."""
    return 200 if soak else 25


def success(plan: Plan, count: int) -> float:
    return sum(episode.success for episode in run_all(plan, count, workers=1)) / count


def test_tasks_are_done_from_one_demonstration(count: int) -> None:
    assert success(STACKING, count) >= 0.95


@pytest.mark.parametrize("slips, pushes", [(0.25, 0.0), (0.0, 0.25)])
def test_what_slips_or_is_pushed_is_rebuilt(count: int, slips: float, pushes: float) -> None:
    plan = replace(STACKING, disturbances=Disturbances(slips, pushes))
    assert success(plan, count) >= 0.9


def test_noise_of_two_millimetres_does_no_harm(count: int) -> None:
    assert success(replace(STACKING, disturbances=Disturbances(noise=0.002)), count) >= 0.95


def test_more_blocks_and_higher_towers_are_no_harder(count: int) -> None:
    assert success(replace(STACKING, task="tall_towers"), count) >= 0.95


DISTURBED = pytest.mark.parametrize(
    "disturbances", [Disturbances(), Disturbances(slips=0.25), Disturbances(pushes=0.25)]
)


@DISTURBED
def test_the_arm_builds_what_it_was_shown(disturbances: Disturbances) -> None:
    arm_builds(replace(STACKING, world="bullet", disturbances=disturbances), 2)


@pytest.mark.authors_data
@DISTURBED
def test_the_arm_builds_the_authors_own_tasks(
    soak: bool, authors_data: Path, disturbances: Disturbances
) -> None:
    tasks = authors_data / "stack_unseen_500.json"
    arm_builds(replace(STACKING, world="bullet", tasks=tasks, disturbances=disturbances), 100 if soak else 3)


def arm_builds(plan: Plan, count: int) -> None:
    episodes = list(run_all(plan, count, workers=1))
    wanted = 0.95 if plan.disturbances == Disturbances() else 0.9
    assert sum(episode.success for episode in episodes) >= wanted * len(episodes)
    assert all(episode.simulated_seconds > 2 for episode in episodes)


@pytest.mark.parametrize("world", ["kinematic", "bullet", "mujoco"])
def test_the_number_of_workers_does_not_matter(world: str) -> None:
    plan = replace(STACKING, world=world, task="few_placements", disturbances=Disturbances(0.25, 0.25))
    one, two = (list(run_all(plan, 2, workers)) for workers in (1, 2))
    assert one == two


def test_the_expert_always_succeeds_in_the_kinematic_world() -> None:
    plan = replace(SCRIPTED, disturbances=Disturbances(slips=0.25, pushes=0.25))
    assert success(plan, 40) == 1.0


def test_an_unknown_task_or_world_is_refused_with_the_known_ones() -> None:
    with pytest.raises(NtpError, match="(?s)no task is called 'juggling'.*The paper's"):
        next(run_all(replace(STACKING, task="juggling"), 1, 1))
    with pytest.raises(NtpError, match="no world is called 'mars'.*bullet"):
        next(run_all(replace(STACKING, world="mars"), 1, 1))


def test_every_failure_is_attributed() -> None:
    def episode(number: int, cause: Attribution | None) -> Episode:
        return Episode(number, "t", 3, not cause, not cause, cause, "", 9, 10.0, 0, 1, {}, None)

    causes = [None, Attribution.GRASP, Attribution.DECISION]
    figures = statistics([episode(*each) for each in enumerate(causes)], seed=5)
    assert figures.success == pytest.approx(1 / 3)
    assert figures.failures == {"decision": 1, "planner": 0, "grasp": 1, "physics": 0, "disturbance": 0}
    assert [row.episode for row in figures.failed] == [1, 2]


def test_the_interval_is_wilsons() -> None:
    low, high = wilson(95, 100)
    assert (low, high) == (pytest.approx(0.8882, abs=1e-3), pytest.approx(0.9785, abs=1e-3))
    assert wilson(10, 10)[1] == 1.0 and wilson(0, 10)[0] == 0.0
