"""Goals that a function in Python draws: their fields are objects, members and numbers."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from msgspec import convert, to_builtins

from ntp_dsl.language.diagnostics.diagnostics import NtpError
from ntp_dsl.semantics.facts import Literal
from ntp_dsl.semantics.observation import Record
from ntp_dsl.tasks.goal_samplers import Goal
from ntp_dsl.tasks.instances import draw, find_task
from ntp_dsl.user_code.loading import load_with_python

LIBRARY = """
library mine
use tabletop

type Mark is Place
enum Side: left, right
record Spot(item: Movable, mark: Place, side: Side, distance: length)

predicate laid(item: Movable, mark: Place, side: Side, distance: length) by python

program lay(goal: list[Spot]):
    achieves all laid(s.item, s.mark, s.side, s.distance) for s in goal
    for s in goal:
        put_beside(s.item, s.mark, s.side, s.distance)

program put_beside(item: Movable, mark: Place, side: Side, distance: length):
    requires present(item) and reachable(item)
    achieves laid(item, mark, side, distance)
    pick(item)
    put_down()

task mine:
    scene:
        marks: 2 Mark on table with box(5 cm, 5 cm, 1 cm)
        blocks: 3 Block on table
    goal:    spots(blocks, marks, Side) -> list[Spot] by python
    run:     lay(goal)
    success: all laid(s.item, s.mark, s.side, s.distance) for s in goal
"""
PYTHON = """
from ntp_dsl.authoring import predicate, sampler

@predicate
def laid(observation, item, mark, side, distance):
    return abs(observation.positions[item][0] - distance) < 0.01

@sampler
def spots(rng, blocks, marks, sides):
    return [{row}]
"""
ROW = "(blocks[0], marks[1], sides[0], 0.25)"


def drawn(folder: Path, row: str) -> Goal:
    (folder / "mine.ntp").write_text(LIBRARY)
    (folder / "mine.py").write_text(PYTHON.format(row=row))
    registry = load_with_python(folder / "mine.ntp")
    return draw(registry, find_task(registry, "mine"), np.random.default_rng(0)).goal


@pytest.mark.parametrize("row", [ROW, ROW.replace("0.25", "rng.uniform(0.25, 0.25)")])
def test_a_number_in_a_goal_is_a_number_there_and_back(tmp_path: Path, row: str) -> None:
    (spot,) = drawn(tmp_path, row)
    assert spot.fields == (("item", "block_0"), ("mark", "mark_1"), ("side", "left"), ("distance", 0.25))
    assert convert(to_builtins(spot), Record) == spot


def test_a_goal_is_told_without_its_machinery(tmp_path: Path) -> None:
    (spot,) = drawn(tmp_path, ROW)
    assert str(Literal("laid", (spot,))) == "laid((block_0, mark_1, left, 0.25))"


def test_a_constant_of_the_library_may_be_part_of_a_goal(tmp_path: Path) -> None:
    assert drawn(tmp_path, ROW.replace("marks[1]", "'table'"))[0]["mark"] == "table"


@pytest.mark.parametrize(
    ("row", "said"),
    [
        (ROW.replace("0.25", "'near'"), "drew 'near' for 'distance: length'; expected a number"),
        (
            ROW.replace("marks[1]", "'mark_7'"),
            "drew 'mark_7' for 'mark: Place'; expected the name of an object",
        ),
        (ROW.replace("sides[0]", "'top'"), "drew 'top' for 'side: Side'; expected left or right"),
        (ROW.replace(", 0.25", ""), r"yields rows of \(item, mark, side, distance\)"),
    ],
)
def test_what_a_sampler_draws_must_fit_its_field(tmp_path: Path, row: str, said: str) -> None:
    with pytest.raises(NtpError, match=said):
        drawn(tmp_path, row)


def test_a_sampler_is_told_what_each_object_starts_on(tmp_path: Path) -> None:
    on_marks = LIBRARY.replace("3 Block on table", "2 Block on marks")
    (tmp_path / "mine.ntp").write_text(on_marks)
    told = PYTHON.format(row='("block_0", starts["block_0"], "left", 0.25)').replace(
        "sides)", "sides, starts)"
    )
    (tmp_path / "mine.py").write_text(told)
    registry = load_with_python(tmp_path / "mine.ntp")
    drawn = [draw(registry, find_task(registry, "mine"), np.random.default_rng(seed)) for seed in range(20)]
    assert {each.goal[0]["mark"] for each in drawn} == {"mark_0", "mark_1"}
    assert all(each.goal[0]["mark"] == each.starts["block_0"].surface for each in drawn)
