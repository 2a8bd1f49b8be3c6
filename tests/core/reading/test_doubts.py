"""A reading says which elements might as well be others, and how probable each is."""

from __future__ import annotations

from math import isclose

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from one_core_samples import library, read, shown, the_model

from ntp_dsl.core.reading.likelihood import Places, places
from ntp_dsl.semantics.observation import Observation, Record, SceneObject
from ntp_dsl.semantics.state import State

CLEAR = [  # tasks of whose lists a demonstration leaves nothing open
    ("block_stacking", "block_stacking"),
    ("seating", "changing_places"),
    ("set_the_table", "set_the_table"),
    ("table_cleanup", "three_and_three"),
    *((name, name) for name in ("depot", "hanoi", "kitting", "line_up", "picnic", "unpacking", "village")),
]
BLOCK = SceneObject("block", "Block", (0.05, 0.05, 0.05))


def about(offset: float) -> Places:
    """Return the places about a block that lies at an offset along x from the origin [m]."""
    registry = library("block_stacking")
    seen = Observation((BLOCK,), {"block": (offset, 0.0, 0.0)}, (0.0, 0.0, 0.5), False)
    return places(State(registry, seen), "block", lambda looks: [State(registry, each) for each in looks])


def within(radius: float) -> object:
    return lambda state: float(np.linalg.norm(state.observation.positions["block"])) < radius


@pytest.mark.parametrize(("name", "task"), CLEAR)
def test_what_a_demonstration_tells_is_not_doubted(name: str, task: str) -> None:
    for seed in (3, 4):
        reading = read(*shown(name, seed, task))
        assert reading.doubts == () and reading.probability == 1.0


def test_which_pillar_is_the_left_one_is_doubted() -> None:
    """A plank lies on two pillars, and nothing tells the left one from the right one."""
    reading = read(*shown("bridges", 3))
    (elements,) = reading.arguments
    assert isinstance(elements, tuple) and len(reading.doubts) == len(elements)
    for doubt, element in zip(reading.doubts, elements, strict=True):
        assert isinstance(element, Record) and doubt.element == element and doubt.probability == 0.5
        ((other, chance),) = doubt.others
        assert isinstance(other, Record) and chance == 0.5
        assert {*dict(other.fields).values()} == {*dict(element.fields).values()}
    assert isclose(reading.probability, 0.5 ** len(elements))


def test_what_somebody_says_is_meant_is_what_is_done() -> None:
    task, demonstration = shown("bridges", 3)
    instance = task.instance
    source = the_model(task.registry, instance.program).read(demonstration)
    before = source.reading(instance.program, instance.arguments, source.scope())
    doubt = before.doubts[0]
    source.settle(instance.program, instance.arguments, source.scope(), {doubt: doubt.others[0][0]})
    after = source.reading(instance.program, instance.arguments, source.scope())
    assert after.arguments[0][doubt.number] == doubt.others[0][0]  # type: ignore[index]
    assert after.arguments[0][1:] == before.arguments[0][1:]  # type: ignore[index]
    assert after.is_whole and after.doubts[0].answer == doubt.others[0][0]
    assert after.probability == pytest.approx(2 * before.probability)


@given(st.floats(0, 0.018), st.floats(0.001, 0.01))
def test_things_are_put_in_the_middle_rather_than_at_the_margin(near: float, further: float) -> None:
    holds = within(0.02)
    likely = [about(each).likelihood(holds) for each in (near, min(near + further, 0.0195))]  # type: ignore[arg-type]
    assert likely[0] >= 0.8 * likely[1] > 0
    assert about(0.021).likelihood(holds) == 0.0  # type: ignore[arg-type]


def test_the_narrower_of_two_elements_that_hold_is_the_likelier() -> None:
    wide, narrow = (about(0.001).likelihood(within(radius)) for radius in (0.03, 0.006))  # type: ignore[arg-type]
    assert narrow > wide


@pytest.mark.parametrize(("name", "unshown"), [("lorry", ()), ("unpacking", ()), ("hanoi", ())])
def test_a_predicate_over_whole_records_may_show_any_field(name: str, unshown: tuple[str, ...]) -> None:
    assert read(*shown(name, 3)).unshown == unshown
