"""A clock with a gap, a camera that moves, a hand that is tracked elsewhere or late: each is told."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from ntp_dsl import demonstrate, draw, load
from ntp_dsl.demonstrations.demonstration import Demonstration
from ntp_dsl.evaluation.tracking_remarks import tracking_remarks
from ntp_dsl.semantics.observation import SceneObject
from ntp_dsl.worlds.habits import Person
from ntp_dsl.worlds.people import PersonWorld


@pytest.fixture(scope="module")
def shown() -> Demonstration:
    return demonstrate(draw(load("seating"), "seating", 1)).demonstration


def told(shown: Demonstration) -> str:
    """Return the only remark."""
    [found] = tracking_remarks(shown)
    return found


@pytest.mark.parametrize("person", [Person.ANYBODY, Person.REGRASPS, Person.PAUSES])
def test_of_what_people_do_nothing_is_odd(person: Person) -> None:
    for seed in range(3):
        task = draw(load("table_cleanup"), "three_and_three", seed)
        assert [*tracking_remarks(demonstrate(task, PersonWorld(person, 30.0)).demonstration)] == []


def test_a_gap_of_the_clock_is_told(shown: Demonstration) -> None:
    frames = np.arange(len(shown)) > len(shown) // 2
    later = replace(shown, times=(shown.times + 2.5 * frames).astype(np.float32))
    assert told(later).startswith("nothing is shown from ")


def test_a_camera_that_moves_is_told(shown: Demonstration) -> None:
    positions = shown.positions.copy()
    positions[len(shown) // 2 :] += (0.03, 0.02, 0.0)
    assert told(replace(shown, positions=positions)) == (
        f"all objects are 0.04 m elsewhere from frame {len(shown) // 2} on: did the camera move?"
    )


def test_what_never_moves_and_does_is_told(shown: Demonstration) -> None:
    seat = next(index for index, each in enumerate(shown.objects) if not each.movable)
    positions = shown.positions.copy()
    positions[len(shown) // 2 :, seat, 1] += 0.05
    assert told(replace(shown, positions=positions)).endswith(f"at the end: {shown.names[seat]}")


def test_a_hand_that_is_tracked_elsewhere_is_told(shown: Demonstration) -> None:
    aside = replace(shown, grippers=shown.grippers + np.array([0.0, 0.0, 0.15]))
    assert told(aside).startswith("wherever the hand closes, it is ")


def test_a_hand_that_closes_too_late_is_told(shown: Demonstration) -> None:
    late = round(1.5 / float(np.median(np.diff(shown.times))))
    closed = np.concatenate([np.zeros(late, bool), shown.closed[:-late]])
    assert told(replace(shown, closed=closed)).endswith("does `closed` come too late?")


def test_a_hand_in_another_frame_than_the_objects_is_told() -> None:
    stacked = demonstrate(draw(load("block_stacking"), "block_stacking", 1)).demonstration
    mirrored = replace(stacked, positions=stacked.positions * np.array([1.0, -1.0, 1.0], np.float32))
    assert told(mirrored).endswith("are the hand and the objects in one frame?")


def test_what_lies_in_a_tray_that_is_carried_by_its_rim_is_not_odd() -> None:
    objects = tuple(
        SceneObject(name, "Thing", size)
        for name, size in (("tray", (0.4, 0.3, 0.02)), ("cup", (0.05,) * 3), ("jug", (0.05,) * 3))
    )
    way = np.linspace(0.0, 0.4, 41)[:, None] * np.array([0.0, 1.0, 0.0])
    hand = np.array([0.4, 0.0, 0.05]) + way
    starts = np.array([(0.6, 0.0, 0.02), (0.7, 0.05, 0.05), (0.7, -0.05, 0.05)])
    places = starts[None] + way[:, None]
    times = np.linspace(0.0, 4.0, 41, dtype=np.float32)
    carried = Demonstration(objects, times, np.ones(41, dtype=bool), hand, places)
    assert "frame" not in " ".join(tracking_remarks(carried))
