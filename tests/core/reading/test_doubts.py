"""A reading says which elements might as well be others, and how probable each is."""

from __future__ import annotations

from collections.abc import Callable
from math import cos, isclose, sin

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from one_core_samples import library, read, shown, the_model

from ntp_dsl.common.resources import examples_folder
from ntp_dsl.core.one_core import shipped_core
from ntp_dsl.core.reading.likelihood import Places, places
from ntp_dsl.core.reading.reading import Reading
from ntp_dsl.evaluation.episodes import Evaluator, Plan
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


def about(offset: float, angle: float = 0.0) -> Places:
    """Return the places about a block that lies at an offset from the origin [m]."""
    registry = library("block_stacking")
    at = (offset * cos(angle), offset * sin(angle), 0.0)
    seen = Observation((BLOCK,), {"block": at}, (0.0, 0.0, 0.5), False)
    return places(State(registry, seen), "block", lambda looks: [State(registry, each) for each in looks])


def within(radius: float) -> Callable[[State], bool]:
    """Return whether a block lies within a radius of the origin."""
    return lambda state: float(np.linalg.norm(state.observation.positions["block"])) < radius


def fit(offset: float, angle: float, radius: float) -> float:
    """Return how likely a block is put down at an offset by who wants it within a radius."""
    found = about(offset, angle).likelihood(within(radius))
    assert found is not None
    return found


def elements(reading: Reading) -> tuple[object, ...]:
    """Return the elements of the only list that is read."""
    (found,) = reading.arguments
    assert isinstance(found, tuple)
    return found


@pytest.mark.parametrize(("name", "task"), CLEAR)
def test_what_a_demonstration_tells_is_not_doubted(name: str, task: str) -> None:
    for seed in (3, 4):
        reading = read(*shown(name, seed, task))
        assert reading.doubts == () and reading.probability == 1.0


def test_which_of_two_bays_is_lit_that_have_one_middle_is_doubted() -> None:
    reading = read(*shown("lanterns", 3, "in_doubt"))
    bays = elements(reading)
    assert len(reading.doubts) == len(bays) == 2
    for doubt, bay in zip(reading.doubts, bays, strict=True):
        assert doubt.element == bay and isclose(doubt.probability, 0.5, rel_tol=0.01)
        ((other, chance),) = doubt.others
        assert isclose(chance, 0.5, rel_tol=0.01)
        (lantern, some), (the_same, others) = posts(bay), posts(other)
        assert lantern == the_same and not some & others
    assert isclose(reading.probability, 0.25, rel_tol=0.02)


def test_objects_that_may_change_places_are_not_doubted() -> None:
    """A plank lies on two pillars, and it does not matter which is the left one."""
    for seed in (3, 4):
        reading = read(*shown("bridges", seed))
        assert elements(reading) and reading.doubts == () and reading.probability == 1.0


def test_what_somebody_says_is_meant_is_what_is_done() -> None:
    task, demonstration = shown("lanterns", 3, "in_doubt")
    instance = task.instance
    source = the_model(task.registry, instance.program).read(demonstration)
    before = source.reading(instance.program, instance.arguments, source.scope())
    doubt = before.doubts[0]
    source.settle(instance.program, instance.arguments, source.scope(), {doubt: doubt.others[0][0]})
    after = source.reading(instance.program, instance.arguments, source.scope())
    (first, *others), (meant, *same) = elements(before), elements(after)
    assert (first, meant) == (doubt.element, doubt.others[0][0]) and same == others
    assert after.is_whole and after.doubts[0].answer == doubt.others[0][0]
    assert after.probability == pytest.approx(2 * before.probability, rel=0.02)


def test_objects_are_put_in_the_middle_rather_than_at_the_margin() -> None:
    likely = [fit(offset, 0.0, 0.02) for offset in (0.0, 0.006, 0.012, 0.018)]
    assert likely[0] > 2 * likely[1] > 4 * likely[2] > 4 * likely[3] > 0
    assert about(0.021).likelihood(within(0.02)) == 0.0


@given(st.floats(0, 0.014), st.floats(0, 6.28))
def test_what_holds_all_around_has_no_middle(offset: float, angle: float) -> None:
    """As in a bowl, where things are put down anywhere: it is not compared with what has one."""
    for wide in (0.1, 1.0):
        assert about(offset, angle).likelihood(within(wide)) is None


@given(st.floats(0, 0.015), st.floats(0, 6.28))
def test_no_direction_is_preferred(offset: float, angle: float) -> None:
    """Twelve places are tried all around."""
    some, turned = (fit(offset, each, 0.0182) for each in (angle, angle + np.pi / 6))
    assert turned == pytest.approx(some, rel=0.05)


def test_of_elements_that_explain_as_much_the_one_is_read_whose_place_it_is() -> None:
    """A lantern before one post stands 1 cm from where it would light the bay of the posts beside it."""
    for seed in range(3, 9):
        task, demonstration = shown("lanterns", seed)
        reading = read(task, demonstration)
        (bays,), (meant,) = reading.arguments, task.instance.arguments
        assert isinstance(bays, tuple) and isinstance(meant, tuple)
        assert [posts(bay) for bay in bays] == [posts(bay) for bay in meant], seed


def posts(bay: object) -> tuple[object, set[object]]:
    """Return a bay's lantern, and its posts, which are not told apart."""
    assert isinstance(bay, Record)
    lantern, one, other = dict(bay.fields).values()
    return lantern, {one, other}


@pytest.mark.parametrize(
    ("name", "task", "unshown"), [("lorry", "lorry", ()), ("unpacking", "emptying", ("goal.shelf",))]
)
def test_a_predicate_over_whole_records_may_show_any_field(
    name: str, task: str, unshown: tuple[str, ...]
) -> None:
    assert read(*shown(name, 3, task)).unshown == unshown


def test_forks_that_lie_on_one_another_in_a_bowl_are_read_as_in_the_bowl() -> None:
    """One that is thrown in may come to lie just upon another, and does not belong there for that."""
    for seed in (3, 4):
        task, demonstration = shown("table_cleanup", seed, "four_and_twelve")
        assert read(task, demonstration).arguments == task.instance.arguments


def test_what_gets_into_another_bowl_with_its_own_is_read_as_in_its_own() -> None:
    """A fork at the bottom of a bowl that is stacked lies in the bowl below as well, in the end."""
    evaluator = Evaluator(
        Plan(examples_folder() / "table_cleanup", "four_and_twenty", shipped_core(), seed=41)
    )
    instance = evaluator.instance(4)
    recorded, _ = evaluator.demonstration(instance, 4)
    source = the_model(evaluator.registry, instance.program).read(recorded.demonstration)
    reading = source.reading(instance.program, instance.arguments, source.scope())
    assert reading.arguments == instance.arguments
