"""The instances of an evaluation always have something to do."""

from __future__ import annotations

from pathlib import Path

import pytest

from ntp_dsl.evaluation.episode_parts import starting_scene
from ntp_dsl.evaluation.episodes import Evaluator, Plan
from ntp_dsl.language.diagnostics.diagnostics import NtpError

LIBRARY = """library mine
use tabletop
type Plate is Place
type Jar is Movable

program arrange(goal: list[Placement]):
    achieves all on(p.item, p.support) for p in goal
    for p in goal:
        pick_and_place(p.item, p.support)

task exchange:
    scene:
        plates: 2 Plate on table with box(10 cm, 10 cm, 1 cm)
        jars: 2 Jar on plates with cylinder(5 cm, 7 cm)
    goal: permutations(jars, plates) -> list[Placement]
    run: arrange(goal)
    success: all on(p.item, p.support) for p in goal

task nothing:
    scene:
        plates: 1 Plate on table with box(10 cm, 10 cm, 1 cm)
        jars: 1 Jar on plates with cylinder(5 cm, 7 cm)
    goal: permutations(jars, plates) -> list[Placement]
    run: arrange(goal)
    success: all on(p.item, p.support) for p in goal
"""


@pytest.fixture
def library(tmp_path: Path) -> Path:
    path = tmp_path / "mine.ntp"
    path.write_text(LIBRARY)
    return path


def test_a_goal_that_holds_from_the_start_is_drawn_again(library: Path) -> None:
    evaluator = Evaluator(Plan(library, "exchange", None, "kinematic", seed=0))
    for number in range(20):
        instance = evaluator.instance(number)
        assert not instance.holds_in(
            evaluator.registry, starting_scene(evaluator.registry, instance, evaluator.plan.seed, number)
        )
        assert instance.goal == evaluator.instance(number).goal
        assert evaluator.episode(number).success


def test_a_task_whose_goals_all_hold_from_the_start_is_refused(library: Path) -> None:
    with pytest.raises(NtpError, match="hold at the start"):
        Evaluator(Plan(library, "nothing", None, "kinematic", seed=0)).instance(0)
