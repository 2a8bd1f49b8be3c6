"""A demonstration from elsewhere is looked at before it is run, and what is odd about it is said."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from msgspec.structs import replace as with_fields

import ntp_dsl
from ntp_dsl.demonstrations.demonstration import UNKNOWN, Demonstration, noisy
from ntp_dsl.evaluation.demonstration_remarks import remarks
from ntp_dsl.semantics.observation import Record


def said(task: ntp_dsl.Task, shown: Demonstration) -> list[str]:
    return [*remarks(task.registry, task.instance, shown)]


def shown_by_the_expert(library: str, task: str, seed: int) -> tuple[ntp_dsl.Task, Demonstration]:
    drawn = ntp_dsl.draw(ntp_dsl.load(library), task, seed=seed)
    return drawn, ntp_dsl.demonstrate(drawn).demonstration


def first_frames(shown: Demonstration, count: int) -> Demonstration:
    return replace(
        shown,
        times=shown.times[:count],
        closed=shown.closed[:count],
        grippers=shown.grippers[:count],
        positions=shown.positions[:count],
        orientations=None if shown.orientations is None else shown.orientations[:count],
        deviations=None if shown.deviations is None else shown.deviations[:count],
        facts=None if shown.facts is None else shown.facts[:count],
    )


@pytest.mark.parametrize("library", ["block_stacking", "seating", "object_sorting", "serving", "blueprint"])
@pytest.mark.parametrize("sigma", [0.0, 0.003])
def test_nothing_is_odd_about_the_experts_demonstrations(library: str, sigma: float) -> None:
    for seed in range(3):
        task, shown = shown_by_the_expert(library, library, seed)
        assert said(task, noisy(shown, sigma, np.random.default_rng(seed)) if sigma else shown) == []


def test_an_object_in_the_hand_at_the_end_is_told() -> None:
    task, shown = shown_by_the_expert("block_stacking", "few_placements", 1)
    held = [frame for frame, closed in enumerate(shown.closed) if closed]
    cut = first_frames(shown, held[len(held) // 2])
    told = said(task, cut)
    assert "ends with block_" in told[0] and "in the hand" in told[0]
    assert "does not end in the goal that it states" in told[1]


def test_a_hand_that_never_closes_is_told() -> None:
    task, shown = shown_by_the_expert("block_stacking", "few_placements", 1)
    told = said(task, replace(shown, closed=np.zeros_like(shown.closed)))
    assert len(told) == 1 and "never closed" in told[0]


def test_a_goal_that_is_another_is_told() -> None:
    task, shown = shown_by_the_expert("block_stacking", "block_stacking", 1)
    names = [name for name, _ in shown.origin.goal[0].fields]
    item, support = (str(shown.origin.goal[0][name]) for name in names)
    swapped = Record(shown.origin.goal[0].type, ((names[0], support), (names[1], item)))
    told = said(task, replace(shown, origin=with_fields(shown.origin, goal=(swapped,))))
    assert told == [
        f"the demonstration does not end in the goal that it states: at its end, not on({support}, {item})"
    ]


def test_without_a_goal_nothing_is_compared() -> None:
    task, shown = shown_by_the_expert("block_stacking", "few_placements", 1)
    cut = replace(first_frames(shown, len(shown) // 3), origin=UNKNOWN)
    assert not any("goal" in each for each in said(task, cut))


def test_a_demonstration_that_begins_with_a_closed_hand_is_told() -> None:
    task, shown = shown_by_the_expert("block_stacking", "few_placements", 1)
    begin = int(np.argmax(shown.closed)) + 2
    late = first_frames(shown, len(shown))
    late = replace(
        late,
        **{
            name: values[begin:]
            for name in ("times", "closed", "grippers", "positions", "orientations", "deviations", "facts")
            if (values := getattr(late, name)) is not None
        },
    )
    assert "does it begin too late?" in said(task, late)[0]


def test_an_object_that_is_somewhere_else_at_once_is_told() -> None:
    task, shown = shown_by_the_expert("block_stacking", "few_placements", 1)
    places = shown.positions.copy()
    places[-3:, 0] += (0.3, 0.0, 0.0)
    told = said(task, replace(shown, positions=places))
    assert f"{shown.names[0]} jumps by 0.30 m at frame {len(shown) - 3}" in told[0]


def test_a_hand_that_carries_nothing_is_told() -> None:
    task, shown = shown_by_the_expert("block_stacking", "few_placements", 1)
    still = replace(shown, positions=np.repeat(shown.positions[:1], len(shown), axis=0))
    assert any("and no object moves with it" in each for each in said(task, still))
