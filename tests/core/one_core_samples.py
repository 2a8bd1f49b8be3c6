"""Tasks, demonstrations and readings for the tests of the one core."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from ntp_dsl.api import Task, demonstrate, draw
from ntp_dsl.common.resources import examples_folder
from ntp_dsl.core.models import OneCoreModel, open_model
from ntp_dsl.core.one_core import OneCore, load_one_core, shipped_core
from ntp_dsl.core.reading.reading import Reading
from ntp_dsl.demonstrations.demonstration import Demonstration
from ntp_dsl.language.registry import Registry
from ntp_dsl.semantics.observation import Argument, Record
from ntp_dsl.semantics.predicates import JUDGED
from ntp_dsl.semantics.state import State
from ntp_dsl.tasks.instances import Instance
from ntp_dsl.user_code.loading import load_with_python
from ntp_dsl.worlds.protocol import World

DOMAINS = Path(__file__).parents[1] / "evaluation" / "domains"
NOBODY = "nobody"  # an object that no test names otherwise

Elements = list[tuple[str | float, ...]]


@cache
def library(name: str) -> Registry:
    """Return an example, or a domain of the evaluation."""
    example = examples_folder() / name
    return load_with_python(example if example.is_dir() else DOMAINS / name)


@cache
def the_core() -> OneCore:
    return load_one_core(shipped_core())


def the_model(registry: Registry, program: str) -> OneCoreModel:
    found = open_model(shipped_core(), registry, program)
    assert isinstance(found, OneCoreModel)
    return found


@cache
def shown(name: str, seed: int, task: str = "") -> tuple[Task, Demonstration]:
    """Return a task, and the expert's demonstration of it."""
    drawn = draw(library(name), task or name, seed)
    return drawn, demonstrate(drawn).demonstration


def read(task: Task, demonstration: Demonstration) -> Reading:
    """Return what a demonstration says of the lists of a task's program."""
    instance = task.instance
    source = the_model(task.registry, instance.program).read(demonstration)
    scope = source.scope()
    assert scope is not None
    return source.reading(instance.program, instance.arguments, scope)


def lists(arguments: Sequence[Argument], names: Mapping[str, str] | None = None) -> list[Elements]:
    """Return the elements of each list among arguments, objects by other names."""
    called: Callable[[Any], Any] = (lambda value: names.get(value, value)) if names else lambda value: value
    return [
        [
            tuple(called(value) for _, value in each.fields) if isinstance(each, Record) else (called(each),)
            for each in argument
        ]
        for argument in arguments
        if isinstance(argument, tuple)
    ]


def without_numbers(found: list[Elements]) -> list[Elements]:
    return [
        [tuple(value for value in each if isinstance(value, str)) for each in elements] for elements in found
    ]


def numbers(found: list[Elements]) -> list[float]:
    return [
        float(value)
        for elements in found
        for each in elements
        for value in each
        if not isinstance(value, str)
    ]


def is_built(registry: Registry, instance: Instance, world: World) -> bool:
    """Return whether a goal holds in a world, as a success test reads it."""
    now = world.truth()
    state = State(registry, now, JUDGED)
    return all(state.holds(fact) for fact in instance.literals(registry, now))


def resampled(demonstration: Demonstration, rate: float, slower: float = 1.0) -> Demonstration:
    """Return a demonstration at another number of frames a second, by linear interpolation.

    Args:
        slower: how many times as long everything takes.
    """
    old = demonstration.times.astype(float) * slower
    new = np.arange(old[0], old[-1] + 1e-9, 1 / rate)
    new = np.append(new, old[-1]) if new[-1] < old[-1] - 1e-6 else new
    last = np.clip(np.searchsorted(old, new + 1e-9, side="right") - 1, 0, len(old) - 1)
    turns, facts = demonstration.orientations, demonstration.facts
    return replace(
        demonstration,
        times=new.astype(np.float32),
        closed=demonstration.closed[last],
        grippers=_interpolated(demonstration.grippers, old, new),
        positions=_interpolated(demonstration.positions, old, new),
        orientations=None if turns is None else turns[last],
        facts=None if facts is None else tuple(facts[index] for index in last),
    )


def _interpolated(values: np.ndarray, old: np.ndarray, new: np.ndarray) -> np.ndarray:
    flat = values.reshape(len(old), -1)
    columns = [np.interp(new, old, column) for column in flat.T]
    return np.stack(columns, axis=1).reshape(len(new), *values.shape[1:])


def renamed(demonstration: Demonstration, names: Mapping[str, str]) -> Demonstration:
    objects = tuple(replace(obj, name=names.get(obj.name, obj.name)) for obj in demonstration.objects)
    return replace(demonstration, objects=objects)


def reordered(demonstration: Demonstration, order: Sequence[int]) -> Demonstration:
    turns = demonstration.orientations
    return replace(
        demonstration,
        objects=tuple(demonstration.objects[index] for index in order),
        positions=demonstration.positions[:, list(order)],
        orientations=None if turns is None else turns[:, list(order)],
    )


def with_a_distractor(demonstration: Demonstration) -> Demonstration:
    """Return a demonstration with one more object like the first movable one, that lies far away."""
    like = next(obj for obj in demonstration.objects if obj.movable)
    frames = len(demonstration)
    place = np.tile([0.1, -0.75, like.size[2] / 2], (frames, 1, 1))
    turns = demonstration.orientations
    unturned = np.tile(np.array([0, 0, 0, 1], dtype=np.float32), (frames, 1, 1))
    return replace(
        demonstration,
        objects=(*demonstration.objects, replace(like, name=NOBODY)),
        positions=np.concatenate([demonstration.positions, place], axis=1),
        orientations=None if turns is None else np.concatenate([turns, unturned], axis=1),
    )
