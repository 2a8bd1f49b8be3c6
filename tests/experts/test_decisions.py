"""A decision is a function of the program, its arguments and the state, and of nothing else."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from expert_samples import drawn, experts

from ntp_dsl.datasets.labels import random_call
from ntp_dsl.language.loader import load
from ntp_dsl.language.registry import Registry
from ntp_dsl.libraries import load_text
from ntp_dsl.policies.expert import Decision, Expert, ExpertContext, NextCall, UndeclaredCall, call
from ntp_dsl.semantics.facts import Literal
from ntp_dsl.semantics.observation import Argument, Observation, Record, SceneObject
from ntp_dsl.semantics.state import State

SEEDS = range(60)
CARRYING = """
library mine
use tabletop

predicate aside(item: Object): not reachable(item)

program carry(item: Object):
    requires present(item) and reachable(item)
    achieves aside(item)
    pick(item)
    move_to(table)
    release()
"""
Question = tuple[str, tuple[Argument, ...], Observation]


def questions(registry: Registry, seed: int) -> Iterator[Question]:
    """Return the root call and calls of a few other programs, in one perturbed start."""
    instance, world = drawn(registry, seed)
    yield instance.program, instance.arguments, world.truth()
    rng = np.random.default_rng((seed, 7))
    for _ in range(6):
        program, arguments = random_call(Expert(registry), world.truth(), None, rng)
        yield program.name, arguments, world.truth()


def decide(expert: Expert, question: Question) -> Decision:
    program, arguments, observation = question
    return expert.decide(program, arguments, State(expert.registry, observation))


def renamed(question: Question, names: Mapping[str, str]) -> Question:
    program, arguments, seen = question
    objects = tuple(replace(obj, name=names.get(obj.name, obj.name)) for obj in seen.objects)
    positions = {names.get(name, name): place for name, place in seen.positions.items()}
    given = tuple(renamed_argument(argument, names) for argument in arguments)
    return program, given, replace(seen, objects=objects, positions=positions)


def renamed_argument(argument: Argument, names: Mapping[str, str]) -> Argument:
    match argument:
        case str():
            return names.get(argument, argument)
        case Record():
            fields = tuple((key, names.get(value, value)) for key, value in argument.fields)
            return Record(argument.type, fields)
        case tuple():
            return tuple(renamed_argument(each, names) for each in argument)  # type: ignore[misc]
    return argument


@pytest.mark.parametrize("kind", ["declared", "in Python"])
def test_asking_twice_gives_the_same_answer(stacking: Registry, kind: str) -> None:
    expert, again = experts(stacking)[kind], experts(stacking)[kind]
    for seed in SEEDS:
        for question in questions(stacking, seed):
            assert decide(expert, question) == decide(expert, question) == decide(again, question)


@pytest.mark.parametrize("kind", ["declared", "in Python"])
def test_the_order_of_the_objects_does_not_matter(stacking: Registry, kind: str) -> None:
    expert = experts(stacking)[kind]
    for seed in SEEDS:
        rng = np.random.default_rng(seed)
        for program, arguments, seen in questions(stacking, seed):
            order = tuple(int(index) for index in rng.permutation(len(seen.objects)))
            shuffled = (program, arguments, seen.permuted(order))
            assert decide(expert, (program, arguments, seen)) == decide(expert, shuffled)


@pytest.mark.parametrize("kind", ["declared", "in Python"])
def test_names_of_objects_do_not_matter(stacking: Registry, kind: str) -> None:
    expert = experts(stacking)[kind]
    for seed in SEEDS:
        for question in questions(stacking, seed):
            blocks = [obj.name for obj in question[2].objects if obj.type == "Block"]
            order = np.random.default_rng(seed).permutation(len(blocks))
            names = {block: f"object {order[index]}" for index, block in enumerate(blocks)}
            expected, answer = decide(expert, question), decide(expert, renamed(question, names))
            if isinstance(expected, NextCall):
                given = tuple(renamed_argument(each, names) for each in expected.arguments)
                expected = replace(expected, arguments=given)
            assert answer == expected


@pytest.mark.parametrize("kind", ["declared", "in Python"])
def test_more_objects_elsewhere_do_not_matter(stacking: Registry, kind: str) -> None:
    expert = experts(stacking)[kind]
    for seed in SEEDS:
        for program, arguments, seen in questions(stacking, seed):
            if program == "put_down":
                continue  # over the table there is less free place
            more = SceneObject("another", "Block", (0.05, 0.05, 0.05))
            positions = {**seen.positions, "another": (0.9, 0.45, 0.025)}
            fuller = replace(seen, objects=(more, *seen.objects), positions=positions)
            assert decide(expert, (program, arguments, seen)) == decide(expert, (program, arguments, fuller))


def test_a_call_that_a_program_does_not_declare_is_refused(stacking: Registry) -> None:
    expert = Expert(stacking, {"stack": lambda view, goal: call("release")})
    instance, world = drawn(stacking, 1)
    with pytest.raises(UndeclaredCall, match="'stack' calls 'release'; it declares pick_and_place"):
        decide(expert, (instance.program, instance.arguments, world.truth()))


def test_a_python_expert_sees_declared_predicates_and_nothing_else(stacking: Registry) -> None:
    _, world = drawn(stacking, 1)
    state = State(stacking, world.truth())
    view = ExpertContext(stacking, state)
    objects = view.objects("Block")
    assert len(objects) == 10 and "table" not in objects
    assert view.clear(objects[0]) == state.holds(Literal("clear", (objects[0],)))
    with pytest.raises(AttributeError, match="no predicate is called 'positions'"):
        _ = view.positions


def test_the_right_object_is_taken_up_though_the_hand_holds_another(tmp_path: Path) -> None:
    """`release` asks for anything in the hand; what was picked before it is meant."""
    path = tmp_path / "mine.ntp"
    path.write_text(CARRYING)
    registry = load(path)
    objects = (
        *(SceneObject(name, "Block", (0.05, 0.05, 0.05)) for name in "ab"),
        SceneObject("table", "Table", (1.5, 1.5, 0.04)),
    )
    places = {"a": (0.4, 0.1, 0.025), "b": (0.5, 0.0, 0.3), "table": (0.5, 0.0, -0.02)}
    seen = Observation(objects, places, (0.5, 0.0, 0.3), closed=True)
    assert seen.held == "b"
    assert decide(Expert(registry), ("carry", ("a",), seen)) == call("pick", "a")
    assert decide(Expert(registry), ("carry", ("b",), seen)) == call("release")


def test_a_task_that_is_done_returns_done(stacking: Registry) -> None:
    assert decide(Expert(stacking), ("stack", ((),), drawn(stacking, 1)[1].truth())).done  # type: ignore[union-attr]


SHELVED = """
library mine
use tabletop

type Shelf is Place
record Row(shelf: Shelf, item: Block)

program fill(rows: list[Row]):
    achieves all on(r.item, r.shelf) for r in rows
    for r in rows:
        for i in Block if i == r.item:
            bring(i, r.shelf)

program bring(item: Block, shelf: Shelf):
    requires present(item) and reachable(item) and present(shelf) and reachable(shelf)
    achieves on(item, shelf)
    when clear(item):
        pick_and_place(item, shelf)
"""


def test_an_element_of_which_no_call_would_do_anything_does_not_keep_the_others_waiting() -> None:
    registry = load_text(SHELVED)
    objects = tuple(
        SceneObject(name, kind, size)
        for name, kind, size in (
            ("s", "Shelf", (0.2, 0.2, 0.01)),
            ("under", "Block", (0.05, 0.05, 0.05)),
            ("upon", "Block", (0.05, 0.05, 0.05)),
            ("free", "Block", (0.05, 0.05, 0.05)),
        )
    )
    places = {
        "s": (0.5, 0.2, 0.0),
        "under": (0.5, -0.1, 0.025),
        "upon": (0.5, -0.1, 0.075),
        "free": (0.4, 0, 0.025),
    }
    seen = Observation(objects, places, (0.5, 0.0, 0.4), False)
    rows = tuple(Record("Row", (("shelf", "s"), ("item", item))) for item in ("under", "free"))
    answer = Expert(registry).decide("fill", (rows,), State(registry, seen))
    assert answer == call("bring", "free", "s")
