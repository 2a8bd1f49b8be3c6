"""Runs what can be run of a library in an exact kinematic world, and says what could not."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from ntp_dsl.dynamic.api_contract_test import check_honesty
from ntp_dsl.dynamic.expert_rollouts import Rehearsal
from ntp_dsl.dynamic.reach import Reach
from ntp_dsl.language.diagnostics.diagnostics import Diagnostic, NtpError
from ntp_dsl.language.registry import Registry
from ntp_dsl.language.syntax.nodes import (
    NOWHERE,
    Detail,
    Name,
    Number,
    SceneGroup,
    Setting,
    Span,
    TaskDeclaration,
    TypeName,
)
from ntp_dsl.policies.expert import UndeclaredCall
from ntp_dsl.semantics.value_checks import OutOfRange
from ntp_dsl.tasks.goal_samplers import NoGoal
from ntp_dsl.tasks.instances import Instance, draw
from ntp_dsl.user_code.loading import PythonFault
from ntp_dsl.worlds.catalogue import lacking, make_world
from ntp_dsl.worlds.kinematic import KinematicWorld
from ntp_dsl.worlds.scenes import layout

Told = Callable[[str], None]
SCENES = 6  # in which apis and programs are tried: the smallest that the tasks draw
MOST_THINGS = 8  # of a scene for a library without tasks


def check_dynamically(
    registry: Registry, path: Path | None = None, seed: int = 0, told: Told = lambda _: None
) -> list[Diagnostic]:
    """Everything that a simulation finds wrong; deterministic for a seed.

    Args:
        registry: with its functions in Python, or what needs them is not executed and said to be so.
        path: of the library; tasks and programs of those that it uses are left to their own checks.
        told: is given, as it begins, the name of whatever is tried.
    """
    reach = Reach(registry, lacking(KinematicWorld(), registry))
    found = list(reach.not_executed())
    runnable = reach.runnable()
    tasks = [task for task in runnable.tasks.values() if path in (None, task.name_span.path)]
    instances: list[Instance] = []
    sound: list[TaskDeclaration] = []
    for task in tasks:
        try:
            whole = replace(task, scene=_with_readings(task.scene, runnable))
            drawn = [draw(runnable, whole, np.random.default_rng((seed, n))) for n in range(3)]
            for each in drawn:
                each.nominal_start(np.random.default_rng(seed))
        except NtpError as error:
            found.append(_impossible(task, error))
        else:
            instances += drawn
            sound.append(task)
    if not registry.tasks:
        instances = [_some_of_everything(runnable)]
    instances = [each for each in instances if each.objects]  # without any, there is nothing to try
    instances = sorted(instances, key=lambda instance: len(instance.objects))[:SCENES]
    if instances:
        found += _run(runnable, sound, instances, reach, path, seed, told)
    return list(dict.fromkeys(found))  # a function may be at fault in several tasks


def _run(
    registry: Registry,
    tasks: Sequence[TaskDeclaration],
    instances: Sequence[Instance],
    reach: Reach,
    path: Path | None,
    seed: int,
    told: Told,
) -> Iterator[Diagnostic]:
    world = make_world("kinematic", registry, exact=True)
    rehearsal = Rehearsal(registry, world, seed)
    told("apis")
    try:
        found = list(check_honesty(registry, world, instances, seed))
    except NtpError as error:  # a skill or predicate in Python failed
        yield _failed(error, reach, instances[0].task.name_span)
        return
    yield from found
    if any(each.severity == "error" for each in found):
        return  # everything further trusts the apis' contracts
    steps: list[tuple[str, Callable[[], Iterator[Diagnostic]]]]
    steps = [(task.name, lambda task=task: rehearsal.check_task(task)) for task in tasks]  # type: ignore[misc]
    steps += [
        (program.name, lambda program=program: rehearsal.check_program(program, instances))  # type: ignore[misc]
        for program in registry.programs.values()
        if not program.takes_list and path in (None, program.span.path)
    ]
    for name, step in steps:
        told(name)
        try:
            yield from step()
        except NtpError as error:
            task = registry.tasks.get(name)
            if task is not None and isinstance(error, NoGoal):
                yield _impossible(task, error)
            else:
                yield _failed(error, reach, reach.place(name) or NOWHERE)


def _some_of_everything(registry: Registry) -> Instance:
    """A scene for a library without tasks: a few objects of every type that nothing inherits from."""
    inherited = set(registry.parents.values())
    leaves = [name for name in registry.parents if name not in inherited and registry.is_a(name, "Place")]
    types = [name for name in leaves if name not in registry.constants.values()]
    scene = tuple(SceneGroup(name, max(2, MOST_THINGS // len(types)), TypeName(name)) for name in types)
    objects = layout(registry, TaskDeclaration("", scene=_with_readings(scene, registry))).objects
    return Instance(TaskDeclaration(""), objects, (), "", ())


def _with_readings(scene: tuple[SceneGroup, ...], registry: Registry) -> tuple[SceneGroup, ...]:
    """The scene with all that can be read of its objects: what one task has no need to say, a program that is
    tried in its scene may ask."""
    readings = [
        each
        for each in registry.predicates.values()
        if each.result is not None and each.body is None and each.by is None and len(each.parameters) == 1
    ]

    def whole(group: SceneGroup) -> SceneGroup:
        said = {detail.name for detail in group.details}
        more = tuple(
            Detail(each.name, _values(each.result, registry))
            for each in readings
            if each.name not in said and registry.is_a(group.type.name, each.parameters[0].type.name)
        )
        return replace(group, details=(*group.details, *more))

    return tuple(map(whole, scene))


def _values(result: TypeName | None, registry: Registry) -> tuple[Setting, ...]:
    members = registry.enums.get(result.name if result else "", ())
    return tuple(map(Name, members)) or (Number(0.0), Number(1.0))


def _failed(error: NtpError, reach: Reach, place: Span) -> Diagnostic:
    """At the call, or the declaration of the function, that is at fault, where it is known."""
    at_fault = reach.place(error.name) if isinstance(error, PythonFault | UndeclaredCall) else None
    if isinstance(error, OutOfRange) and error.span.path:
        at_fault = error.span
    return Diagnostic("E607", str(error), at_fault or place)


def _impossible(task: TaskDeclaration, error: NtpError) -> Diagnostic:
    if isinstance(error, NoGoal) and task.goal is not None:
        return Diagnostic("E608", f"no goal of '{task.name}' can be drawn: {error}", task.goal.span)
    place = task.scene[0].span if task.scene else task.name_span
    return Diagnostic("E608", f"no scene of '{task.name}' can be made: {error}", place)
