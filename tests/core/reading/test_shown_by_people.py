"""The same list is read whoever demonstrates, and whatever the camera's rate."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from one_core_samples import library, read

from ntp_dsl.api import demonstrate, draw
from ntp_dsl.demonstrations.demonstration import noisy
from ntp_dsl.worlds.habits import Person
from ntp_dsl.worlds.people import PersonWorld

TASKS = {
    "block_stacking": "block_stacking",
    "table_cleanup": "three_and_three",
    "set_the_table": "set_the_table",
    "zoning": "zoning",
}


@pytest.mark.parametrize("person", Person)
@pytest.mark.parametrize("name", TASKS)
def test_what_a_person_shows_is_read_at_every_rate(name: str, person: Person) -> None:
    task = draw(library(name), TASKS[name], seed=5)
    for number, rate in enumerate((10.0, 30.0, 100.0)):
        shown = demonstrate(task, PersonWorld(person, rate)).demonstration
        seen = noisy(shown, 0.003, np.random.default_rng((5, number)))
        assert read(task, seen).arguments == task.instance.arguments, (name, person, rate)


def test_a_hand_that_opens_to_grasp_better_goes_on_holding() -> None:
    """Where what is held is in its zone already, only the acts themselves tell that it is put down there."""
    task = draw(library("zoning"), "zoning", seed=3)
    shown = demonstrate(task, PersonWorld(Person.REGRASPS, 30.0)).demonstration
    opened = np.flatnonzero(np.diff(shown.closed.astype(int)) < 0)
    assert len(opened) > len(task.instance.goal) and read(task, shown).acts == 2 * len(task.instance.goal)


def test_a_hand_that_closes_empty_before_it_leaves_has_let_go() -> None:
    task = draw(library("table_cleanup"), "three_and_three", seed=1)
    shown = demonstrate(task, PersonWorld(Person.STEADY, 30.0)).demonstration
    closed = shown.closed.copy()
    for opened in np.flatnonzero(np.diff(shown.closed.astype(int)) < 0) + 1:
        closed[opened + 10 : opened + 13] = True
    assert read(task, replace(shown, closed=closed)).arguments == task.instance.arguments
