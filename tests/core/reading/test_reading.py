"""What a demonstration says: lists that do not depend on names, order, frame rate, noise or speed."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from math import isclose
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from one_core_samples import (
    NOBODY,
    Elements,
    library,
    lists,
    numbers,
    read,
    renamed,
    reordered,
    resampled,
    shown,
    with_a_distractor,
    without_numbers,
)

from ntp_dsl.api import Task, demonstrate, draw
from ntp_dsl.authoring import call, expert, first
from ntp_dsl.core.perception.steadied import steadied
from ntp_dsl.core.reading.numbers import cuts
from ntp_dsl.core.reading.reading import Reading
from ntp_dsl.demonstrations.demonstration import Demonstration, Recorder, noisy
from ntp_dsl.execution.interpreter import Interpreter, Limits
from ntp_dsl.language.registry import Registry
from ntp_dsl.libraries import load_text
from ntp_dsl.policies.expert import Expert
from ntp_dsl.policies.scripted import ScriptedPolicy
from ntp_dsl.semantics.observation import Argument
from ntp_dsl.semantics.state import State
from ntp_dsl.tasks.instances import Instance
from ntp_dsl.traces.schema import DemonstratedCall
from ntp_dsl.worlds.catalogue import make_world
from ntp_dsl.worlds.protocol import World

DETERMINED = [  # a demonstration shows every element of their lists, and in which order
    ("block_stacking", "block_stacking"),
    ("block_stacking", "tall_towers"),
    ("seating", "seating"),
    ("seating", "changing_places"),
    ("serving", "serving"),
    ("set_the_table", "set_the_table"),
    ("table_cleanup", "table_cleanup"),
    ("object_sorting", "object_sorting"),
    *((name, name) for name in ("depot", "hanoi", "pasture", "picnic", "sandwiches", "unpacking", "village")),
]
NUMBERED = ["beside_the_mark", "garden_rows", "kitting", "line_up"]
VARIED = ["block_stacking", "seating", "table_cleanup", "set_the_table", "sandwiches", "kitting", "line_up"]
CLOSE = 0.005  # [m]
FEW, MANY = 3, 40


def exactly(found: Reading, task: Task, names: dict[str, str] | None = None) -> bool:
    """Return whether a reading is what the task's program was called with, numbers within millimetres."""
    got, wanted = lists(found.arguments, names), lists(task.instance.arguments)
    return without_numbers(got) == without_numbers(wanted) and all(
        isclose(a, b, abs_tol=CLOSE) for a, b in zip(numbers(got), numbers(wanted), strict=True)
    )


def told(found: Reading, task: Task) -> str:
    return f"seed {task.seed}: {lists(found.arguments)} is not {lists(task.instance.arguments)}"


@pytest.mark.parametrize("name, task", DETERMINED)
def test_lists_are_read_as_they_were_given(name: str, task: str, soak: bool) -> None:
    for seed in range(MANY if soak else FEW):
        drawn, demonstration = shown(name, seed, task)
        found = read(drawn, demonstration)
        assert exactly(found, drawn), told(found, drawn)
        assert found.explained == found.acts > 0


@pytest.mark.parametrize("name", NUMBERED)
def test_numbers_are_read_to_the_millimetres(name: str, soak: bool) -> None:
    """In one of a few dozen rows, an object that was put aside stands as if it were part of the row."""
    count, wrong = MANY if soak else FEW, []
    for seed in range(count):
        drawn, demonstration = shown(name, seed)
        found = read(drawn, demonstration)
        assert numbers(lists(found.arguments)) and found.explained == found.acts
        if not exactly(found, drawn):
            wrong.append(told(found, drawn))
    assert len(wrong) <= 0.05 * count, wrong


def test_in_blueprints_the_order_is_that_of_the_hand() -> None:
    """A plan may list towers in any order; what was built is read in the order of building."""
    for seed in range(FEW):
        drawn, demonstration = shown("blueprint", seed)
        (got,), (wanted,) = lists(read(drawn, demonstration).arguments), lists(drawn.instance.arguments)
        assert sorted(map(str, got)) == sorted(map(str, wanted))
        standing: set[object] = {support for _, support in got} - {item for item, _ in got}
        for item, support in got:
            assert support in standing
            standing.add(item)


@pytest.mark.parametrize(
    "name",
    [
        "bridges",
        "butterfly",
        "reflection",
        "change_of_guard",
    ],
)
def test_nothing_is_read_that_was_not_given(name: str) -> None:
    for seed in range(3):
        drawn, demonstration = shown(name, seed)
        found = read(drawn, demonstration)
        assert found.explained == found.acts
        assert without_numbers(lists(found.arguments)) == without_numbers(lists(drawn.instance.arguments))


def test_what_comes_true_by_chance_is_read_too() -> None:
    """A peg that is in the way is put just where it belongs: no call has promised that."""
    drawn, demonstration = shown("beside_the_mark", 5)
    assert exactly(read(drawn, demonstration), drawn)


# What a reading does not depend on


@pytest.mark.parametrize("name", VARIED)
def test_objects_of_other_names_are_read_alike(name: str) -> None:
    for seed in range(FEW):
        drawn, demonstration = shown(name, seed)
        constants = library(name).constants
        others = [each for each in demonstration.names if each not in constants]
        rng = np.random.default_rng(seed)
        names = {old: f"z{index}" for old, index in zip(others, rng.permutation(len(others)), strict=True)}
        back = {new: old for old, new in names.items()}
        call = replace(drawn, instance=with_other_names(drawn.instance, names))
        found = read(call, renamed(demonstration, names))
        assert exactly(found, drawn, back), told(found, drawn)


def with_other_names(instance: Instance, names: dict[str, str]) -> Instance:
    def other(value: Argument) -> Argument:
        return names.get(value, value) if isinstance(value, str) else value

    return replace(instance, arguments=tuple(map(other, instance.arguments)))


@pytest.mark.parametrize("name", VARIED)
def test_the_order_of_objects_does_not_matter(name: str) -> None:
    for seed in range(FEW):
        drawn, demonstration = shown(name, seed)
        order = np.random.default_rng(seed).permutation(len(demonstration.objects)).tolist()
        found = read(drawn, reordered(demonstration, order))
        assert exactly(found, drawn), told(found, drawn)


@pytest.mark.parametrize("name", VARIED)
def test_one_more_object_far_away_is_left_out(name: str) -> None:
    for seed in range(FEW):
        drawn, demonstration = shown(name, seed)
        found = read(drawn, with_a_distractor(demonstration))
        expected = read(drawn, demonstration)
        assert NOBODY not in str(found.arguments)
        assert without_numbers(lists(found.arguments)) == without_numbers(lists(expected.arguments))


@pytest.mark.parametrize("name", VARIED)
@pytest.mark.parametrize("rate", [30, 100])
def test_the_frame_rate_does_not_matter(name: str, rate: float) -> None:
    for seed in range(2):
        drawn, demonstration = shown(name, seed)
        found = read(drawn, resampled(demonstration, rate))
        assert exactly(found, drawn), told(found, drawn)
        assert found.explained == found.acts


@pytest.mark.parametrize("name", VARIED)
@pytest.mark.parametrize("slower, rate", [(10, 10), (0.5, 30)])
def test_a_slow_or_a_fast_hand_says_the_same(name: str, slower: float, rate: float) -> None:
    drawn, demonstration = shown(name, 1)
    found = read(drawn, resampled(demonstration, rate, slower))
    assert exactly(found, drawn), told(found, drawn)
    assert found.explained == found.acts


@pytest.mark.parametrize("name", VARIED)
def test_three_millimetres_of_noise_do_not_matter(name: str, soak: bool) -> None:
    count = MANY if soak else 3
    wrong = []
    for seed in range(count):
        drawn, demonstration = shown(name, seed)
        found = read(drawn, noisy(demonstration, 0.003, np.random.default_rng(seed)))
        if without_numbers(lists(found.arguments)) != without_numbers(lists(drawn.instance.arguments)):
            wrong.append(told(found, drawn))
    assert len(wrong) <= 0.05 * count, wrong


def test_a_tossed_object_order_and_rate_together_change_nothing() -> None:
    drawn, demonstration = shown("block_stacking", 3)
    order = list(reversed(range(len(demonstration.objects))))
    seen = noisy(resampled(reordered(demonstration, order), 30, 2), 0.002, np.random.default_rng(1))
    assert exactly(read(drawn, seen), drawn)


# The calls that are shown


@pytest.mark.parametrize("name", [*VARIED, "serving", "village", "hanoi"])
def test_the_calls_lie_in_one_another_and_in_order(name: str) -> None:
    for seed in range(FEW):
        drawn, demonstration = shown(name, seed)
        found = read(drawn, demonstration)
        assert found.call.name == drawn.instance.program
        assert found.call.scope == (0, len(demonstration))
        check_calls(drawn.registry, found.call)
        primitives = [each for each in found.call.walk() if each.name in drawn.registry.apis]
        opens = [len({*demonstration.closed[slice(*each.scope)].tolist()}) > 1 for each in primitives]
        assert sum(opens) == found.explained


def check_calls(registry: Registry, call: DemonstratedCall) -> None:
    """Assert that calls lie in the scope of their caller, one after the other."""
    at = call.scope[0]
    for child in call.children:
        assert child.name in registry.apis or child.name in registry.programs
        assert call.scope[0] <= child.scope[0] <= child.scope[1] <= call.scope[1], (call, child)
        assert child.scope[0] >= at, "it begins before the one before it ends"
        at = child.scope[1]
        check_calls(registry, child)


def test_the_calls_are_those_that_the_expert_made() -> None:
    for seed in range(FEW):
        drawn, demonstration = shown("block_stacking", seed)
        placed = [
            each.arguments
            for each in read(drawn, demonstration).call.children
            if each.name == "pick_and_place"
        ]
        assert placed == [(row["item"], row["support"]) for row in drawn.goal]


# What is not explained, and what is not there


@pytest.mark.parametrize("name", ["block_stacking", "seating", "sandwiches", "set_the_table"])
def test_a_demonstration_of_nothing_says_nothing(name: str) -> None:
    drawn, demonstration = shown(name, 0)
    idle = int(np.flatnonzero(demonstration.closed)[0])
    found = read(drawn, part_of(demonstration, 0, idle))
    assert all(not elements for elements in lists(found.arguments))
    assert (found.explained, found.acts, found.call.children) == (0, 0, [])


def part_of(demonstration: Demonstration, begin: int, end: int) -> Demonstration:
    turns, deviations = demonstration.orientations, demonstration.deviations
    return replace(
        demonstration,
        times=demonstration.times[begin:end],
        closed=demonstration.closed[begin:end],
        grippers=demonstration.grippers[begin:end],
        positions=demonstration.positions[begin:end],
        orientations=None if turns is None else turns[begin:end],
        deviations=None if deviations is None else deviations[begin:end],
    )


@pytest.mark.parametrize("when", ["before", "after"])
def test_acts_that_no_program_makes_are_not_explained(when: str) -> None:
    """A block is moved about on the table, where no tower is to stand."""
    for seed in range(3):
        drawn, demonstration = shown("block_stacking", seed, "few_placements")
        own = read(drawn, demonstration)
        mixed = with_foreign_acts(drawn, when)
        found = read(drawn, mixed)
        assert own.explained == own.acts
        assert found.acts == own.acts + 2
        assert own.explained <= found.explained < found.acts
        (got,), (wanted,) = lists(found.arguments), lists(drawn.instance.arguments)
        assert got[: len(wanted)] == wanted, told(found, drawn)
        assert not {item for item, _ in got[len(wanted) :]} & {value for each in wanted for value in each}


def with_foreign_acts(task: Task, when: str) -> Demonstration:
    """Return a demonstration before or after which a block is moved that the goal does not name."""
    world = make_world("kinematic", task.registry)
    world.reset(task.scene(), 0)
    recorder = Recorder(world)
    named = {value for row in task.goal for _, value in row.fields}
    bystander = next(obj.name for obj in task.objects if obj.movable and obj.name not in named)
    if when == "before":
        move_aside(world, bystander)
    expert = ScriptedPolicy(Expert(task.registry))
    limits = Limits(primitives=200)
    assert (
        Interpreter(task.registry, expert, world, limits=limits)
        .run(task.instance.program, task.instance.arguments)
        .done
    )
    if when == "after":
        move_aside(world, bystander)
    return recorder.demonstration()


def move_aside(world: World, name: str) -> None:
    world.call("move_to", (name,))
    world.call("grasp", (name,))
    world.call("move_to", ("table",))
    world.call("release", ())
    assert not world.truth().closed


# Numbers that tell objects apart, and the order of elements ---------------------------------------


def test_bounds_are_read_that_take_the_same_objects() -> None:
    """Which bounds an element names cannot be seen; which objects lie between them can."""
    for seed in range(2 * FEW):
        drawn, demonstration = shown("girths", seed)
        found = read(drawn, demonstration)
        scene = State(library("girths"), steadied(demonstration).observation(0))
        sizes = {scene.reading("girth", (pipe,)) for pipe in scene.objects("Pipe")}
        (got,), (wanted,) = lists(found.arguments), lists(drawn.instance.arguments)

        def taken(elements: Elements, sizes: set[float] = sizes) -> set[tuple[object, ...]]:
            return {
                (rack, *(size for size in sorted(sizes) if least - 0.001 <= size <= most + 0.001))
                for rack, least, most in elements
            }

        assert found.explained == found.acts and taken(got) == taken(wanted), told(found, drawn)


def test_elements_come_in_the_order_in_which_they_begin_to_be_done() -> None:
    """Crates are padded long after they are loaded; the list is that of the loading."""
    for seed in range(2 * FEW):
        drawn, demonstration = shown("lorry", seed)
        found = read(drawn, demonstration)
        (got,), (wanted,) = lists(found.arguments), lists(drawn.instance.arguments)
        assert found.explained == found.acts
        for lane in ("port", "starboard"):
            assert [each for each in got if each[-1] == lane] == [each for each in wanted if each[-1] == lane]


@given(st.lists(st.floats(-5, 5).map(lambda value: round(value, 3)), min_size=1, max_size=8))
def test_cuts_tell_all_neighbouring_values_apart(values: list[float]) -> None:
    known, found = sorted(set(values)), cuts(values)
    assert min(found) < known[0] and max(found) > known[-1] and set(known) <= set(found)
    assert all(any(a < each < b for each in found) for a, b in pairwise(known))


ROUNDS = """library rounds
use tabletop
type Dish is Movable
type Cup is Movable
type Mat is Place
record Guest(dish: Dish, cup: Cup, mat: Mat, post: Mat)
program serve(goal: list[Guest]) by python:
    achieves all on(g.dish, g.mat) and on(g.cup, g.post) for g in goal
    calls pick_and_place
task rounds:
    scene:
        dishes: 3 Dish on table
        cups: 3 Cup on table
        mats: 6 Mat on table with box(7 cm, 7 cm, 1 cm)
    goal: {goal}
    run: serve(goal)
    success: all on(g.dish, g.mat) and on(g.cup, g.post) for g in goal
"""
GUESTS = [
    ("dish_1", "cup_1", "mat_1", "mat_5"),
    ("dish_2", "cup_0", "mat_0", "mat_4"),
    ("dish_0", "cup_2", "mat_2", "mat_3"),
]


@expert
def serve(world: Any, goal: Any) -> Any:
    """Bring the dishes in order, and the cups in the opposite one."""
    dishes = [(guest["dish"], guest["mat"]) for guest in goal]
    cups = [(guest["cup"], guest["post"]) for guest in reversed(goal)]
    return first(call("pick_and_place", *each) for each in (*dishes, *cups) if not world.on(*each))


@pytest.mark.parametrize("count", [2, 3])
def test_no_element_is_read_that_explains_nothing_more(count: int) -> None:
    goal = ", ".join(f"({', '.join(guest)})" for guest in GUESTS[:count])
    registry = load_text(ROUNDS.format(goal=goal), [serve])
    for seed in range(4):
        task = draw(registry, "rounds", seed)
        found = read(task, demonstrate(task).demonstration)
        (elements,) = lists(found.arguments)
        assert found.explained == found.acts == 4 * count
        assert sorted(elements) == sorted(GUESTS[:count])
