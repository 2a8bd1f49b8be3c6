"""Simulated people demonstrate: what they show is a success, and each habit is seen in what they show."""

from __future__ import annotations

import numpy as np
import pytest

import ntp_dsl
from ntp_dsl.api import Task
from ntp_dsl.demonstrations.demonstration import Demonstration
from ntp_dsl.worlds.habits import Person
from ntp_dsl.worlds.people import PersonWorld


@pytest.fixture(scope="module")
def task() -> Task:
    return ntp_dsl.draw(ntp_dsl.load("block_stacking"), "block_stacking", seed=3)


def shown(task: Task, person: Person, rate: float = 30.0) -> Demonstration:
    return ntp_dsl.demonstrate(task, PersonWorld(person, rate)).demonstration


def events(demonstration: Demonstration) -> int:
    """Return how often the hand opens or closes."""
    return int(np.abs(np.diff(demonstration.closed.astype(int))).sum())


@pytest.mark.parametrize("rate", [10.0, 30.0, 100.0])
def test_there_are_as_many_frames_a_second_as_asked_for(task: Task, rate: float) -> None:
    times = shown(task, Person.STEADY, rate).times
    assert np.median(np.diff(times)) == pytest.approx(1 / rate, rel=0.01)


def test_the_same_seed_is_the_same_demonstration(task: Task) -> None:
    some, other = shown(task, Person.ANYBODY), shown(task, Person.ANYBODY)
    assert np.array_equal(some.positions, other.positions) and np.array_equal(some.times, other.times)


@pytest.mark.parametrize("person", [Person.REGRASPS, Person.SECOND_THOUGHTS])
def test_who_thinks_twice_grasps_more_often(task: Task, person: Person) -> None:
    assert events(shown(task, person)) > events(shown(task, Person.STEADY))


@pytest.mark.parametrize("person", [Person.PAUSES, Person.OVERSHOOTS, Person.FALSE_STARTS, Person.GOES_HOME])
def test_detours_take_time(task: Task, person: Person) -> None:
    assert shown(task, person).times[-1] > shown(task, Person.STEADY).times[-1]


def test_a_tremor_shakes_the_hand_with_what_it_holds(task: Task) -> None:
    steady, tremor = shown(task, Person.STEADY), shown(task, Person.TREMOR)
    offsets = tremor.grippers - steady.grippers
    assert offsets.std() == pytest.approx(0.002, rel=0.3)
    moved = (tremor.positions - steady.positions)[steady.closed]
    is_shaken = np.isclose(moved, offsets[steady.closed, None]).all(axis=2)
    assert (is_shaken.sum(axis=1) == 1).all()


def test_low_lifts_stay_low(task: Task) -> None:
    lifted = [np.median(shown(task, each).grippers[:, 2]) for each in (Person.LOW_LIFTS, Person.STEADY)]
    assert lifted[0] < lifted[1] - 0.03


def test_grasps_beside_the_middle_hold_objects_there(task: Task) -> None:
    found = shown(task, Person.OFF_CENTRE)
    near = np.linalg.norm((found.positions - found.grippers[:, None])[found.closed], axis=2).min(axis=1)
    assert 0.002 < near.max() < 0.015


def test_nudges_move_what_nobody_grasps(task: Task) -> None:
    found = shown(task, Person.NUDGES)
    span = np.ptp(found.positions, axis=0)
    assert ((span[:, 2] < 0.001) & (np.hypot(span[:, 0], span[:, 1]) > 0.014)).any()
