"""The built-in predicates: what counts as on, in the way, held and above."""

from __future__ import annotations

from math import cos, sin

import pytest

from ntp_dsl.core.one_core import load_one_core, shipped_core
from ntp_dsl.core.perception.grounding import ground
from ntp_dsl.semantics.geometry import Vector
from ntp_dsl.semantics.observation import Observation, SceneObject
from ntp_dsl.semantics.predicates import (
    JUDGED,
    above,
    clear,
    covers,
    empty,
    held,
    holding,
    inside,
    on,
    present,
    reachable,
)

CUBE = (0.05, 0.05, 0.05)
THINGS = (
    SceneObject("a", "Block", CUBE),
    SceneObject("b", "Block", CUBE),
    SceneObject("t", "Table", (1.5, 1.5, 0.04)),
)
FAR = (0.3, -0.2, 0.4)


def seen(
    a: Vector | None, b: Vector = (0.5, 0.0, 0.025), gripper: Vector = FAR, closed: bool = False
) -> Observation:
    places = {"a": a, "b": b, "t": (0.5, 0.0, -0.02)}
    return Observation(THINGS, {name: p for name, p in places.items() if p is not None}, gripper, closed)


@pytest.mark.parametrize(
    "a, is_on, is_in_the_way",
    [
        ((0.5, 0.0, 0.075), True, True),
        ((0.51, 0.0, 0.075), True, True),  # off by a centimetre
        ((0.52, 0.0, 0.075), False, True),  # off by two: accepted, but nothing to aim at
        ((0.53, 0.0, 0.075), False, True),  # off by more: it leans
        ((0.5, 0.03, 0.06), False, True),
        ((0.56, 0.0, 0.025), False, False),  # beside
        ((0.5, 0.0, 0.15), False, False),  # high above
        ((0.5, 0.0, 0.125), False, False),  # two storeys up
    ],
)
def test_what_stands_on_something_covers_it(a: Vector, is_on: bool, is_in_the_way: bool) -> None:
    state = seen(a)
    assert on(state, "a", "b") is is_on
    assert covers(state, "a", "b") is is_in_the_way
    assert clear(state, "b") is not is_in_the_way
    assert not on(state, "b", "a") and not on(state, "a", "a")


def test_everything_low_is_on_the_table_and_nothing_covers_that() -> None:
    state = seen((0.4, 0.1, 0.025))
    assert on(state, "a", "t") and not on(state, "t", "a") and clear(state, "t")
    assert not on(seen((0.4, 0.1, 0.075)), "a", "t")


def test_the_hand_holds_what_is_between_its_closed_fingers() -> None:
    closed = seen((0.5, 0.1, 0.3), gripper=(0.5, 0.1, 0.3), closed=True)
    assert held(closed) == "a" and holding(closed, "a") and holding(closed, "any")
    assert not holding(closed, "b") and not empty(closed, "gripper")
    opened = seen((0.5, 0.1, 0.3), gripper=(0.5, 0.1, 0.3), closed=False)
    missed = seen((0.5, 0.1, 0.3), gripper=(0.5, 0.14, 0.3), closed=True)
    for state in (opened, missed):
        assert held(state) is None and empty(state, "gripper") and not holding(state, "any")


@pytest.mark.parametrize("height", [0.02, 0.05, 0.1, 0.2])
def test_what_is_tall_is_held_near_its_top(height: float) -> None:
    post = SceneObject("post", "Movable", (0.04, 0.04, height), "cylinder")
    middle: Vector = (0.5, 0.1, 0.3)

    def gripped(above_middle: float) -> bool:
        hand = (0.5, 0.1, 0.3 + above_middle)
        return held(Observation((post,), {"post": middle}, hand, True)) == "post"

    assert gripped(0.0) and gripped(max(0.0, height / 2 - 0.025))
    assert not gripped(height / 2 + 0.036)


def test_a_bowl_is_in_the_hand_and_not_the_fork_in_it() -> None:
    bowl = SceneObject("bowl", "Movable", (0.144, 0.144, 0.06), "bowl")
    fork = SceneObject("fork", "Movable", (0.1, 0.02, 0.006), "box")
    places: dict[str, Vector] = {"bowl": (0.5, 0.0, 0.083), "fork": (0.499, 0.036, 0.075)}
    assert held(Observation((fork, bowl), places, (0.452, 0.051, 0.1), True)) == "bowl"


def test_what_is_held_is_on_nothing() -> None:
    state = seen((0.5, 0.0, 0.075), gripper=(0.5, 0.0, 0.075), closed=True)
    assert not on(state, "a", "b") and clear(state, "b")


def test_the_hand_is_above_what_it_is_over() -> None:
    a = (0.4, 0.1, 0.025)
    assert above(seen(a, gripper=(0.5, 0.0, 0.15)), "gripper", "b")
    assert not above(seen(a, gripper=(0.53, 0.0, 0.15)), "gripper", "b")
    assert not above(seen(a, gripper=(0.5, 0.0, 0.4)), "gripper", "b")
    assert not above(seen(a, gripper=(0.5, 0.0, 0.025)), "gripper", "b")


def test_over_the_table_means_over_a_free_place() -> None:
    assert above(seen((0.4, 0.1, 0.025), gripper=(0.6, -0.15, 0.15)), "gripper", "t")
    assert not above(seen((0.4, 0.1, 0.025), gripper=(0.5, 0.0, 0.15)), "gripper", "t")


def test_a_lost_object_is_neither_present_nor_anywhere() -> None:
    state = seen(None)
    assert not present(state, "a") and not reachable(state, "a") and not clear(state, "a")
    assert not on(state, "a", "b") and not covers(state, "a", "b") and clear(state, "b")
    assert not above(state, "gripper", "a")


def test_a_success_test_accepts_more_than_a_program_aims_at() -> None:
    state = seen((0.52, 0.0, 0.075))
    assert not on(state, "a", "b") and JUDGED["on"](state, "a", "b")
    assert not JUDGED["on"](seen((0.526, 0.0, 0.075)), "a", "b")


@pytest.mark.parametrize("tilt", [0.0, 0.3, -0.3, 0.5])
def test_a_bowl_is_held_by_its_rim_however_it_hangs(tilt: float) -> None:
    bowl = SceneObject("bowl", "Bowl", (0.144, 0.144, 0.06), "bowl")
    fork = SceneObject("fork", "Fork", (0.1, 0.018, 0.006), "box")
    along, up = 0.07, 0.017  # from its middle to where the fingers are
    grip = (along * cos(tilt) - up * sin(tilt), 0.0, 0.3 + along * sin(tilt) + up * cos(tilt))

    def holds(fork_at: Vector, gripper: Vector) -> str | None:
        places = {"bowl": (0.0, 0.0, 0.3), "fork": fork_at}
        return held(Observation((bowl, fork), places, gripper, True))

    assert holds(FAR, grip) == "bowl"
    over = (0.01, 0.0, 0.375)  # about to drop a fork into it, as far from its middle as its rim is
    assert holds(over, over) == "fork" and holds(FAR, over) is None


THIN = {
    "tray": SceneObject("tray", "Place", (0.1, 0.1, 0.01), fixed=True),
    "book": SceneObject("book", "Movable", (0.08, 0.1, 0.01)),
    "board": SceneObject("board", "Place", (0.3, 0.3, 0.01), fixed=True),
    "bin": SceneObject("bin", "Place", (0.15, 0.15, 0.06), shape="bin", fixed=True),
}


@pytest.mark.parametrize("below", THIN)
def test_what_stands_on_a_thin_thing_or_lies_in_a_bin_does_not_stand_on_the_table(below: str) -> None:
    thing = THIN[below]
    height = 0.005 if thing.cavity is not None else thing.size[2]  # of what carries the block
    places = {
        "a": (0.5, 0.0, height + 0.025),
        "b": (0.75, 0.0, 0.025),
        "t": (0.5, 0.0, -0.02),
        below: (0.5, 0.0, thing.size[2] / 2),
    }
    moment = Observation((*THINGS, thing), places, FAR, closed=False)
    assert not on(moment, "a", "t") and not JUDGED["on"](moment, "a", "t")
    assert on(moment, "b", "t") and (inside if thing.cavity else on)(moment, "a", below)
    if thing.movable:
        assert on(moment, below, "t")
    network = load_one_core(shipped_core()).grounding
    seen_on = ground(network, moment).contacts
    assert seen_on["a", "t"][0] < 0.5 < seen_on["b", "t"][0]


def test_what_stands_on_a_tray_in_a_crate_stands_on_the_tray() -> None:
    crate = SceneObject("crate", "Place", (0.5, 0.5, 0.12), shape="bin", fixed=True)
    tray = SceneObject("tray", "Place", (0.3, 0.3, 0.01), fixed=True)
    floor = 0.005  # of the crate
    places = {
        "a": (0.5, 0.0, floor + 0.01 + 0.025),
        "b": (0.9, 0.0, 0.025),
        "t": (0.5, 0.0, -0.02),
        "crate": (0.5, 0.0, 0.06),
        "tray": (0.5, 0.0, floor + 0.005),
    }
    moment = Observation((*THINGS, crate, tray), places, FAR, closed=False)
    assert on(moment, "a", "tray") and inside(moment, "a", "crate") and not on(moment, "a", "t")
    seen_on = ground(load_one_core(shipped_core()).grounding, moment).contacts
    assert seen_on["a", "t"][0] < 0.5 < seen_on["a", "tray"][0]
