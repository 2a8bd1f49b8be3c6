"""Simulates the executable part of a library in an exact kinematic world, and notes the rest."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from pathlib import Path

import numpy as np

from ntp_dsl.dynamic.api_contract_test import check_contracts
from ntp_dsl.dynamic.expert_rollouts import ExpertRollouts
from ntp_dsl.dynamic.places import Places
from ntp_dsl.dynamic.reach import Reach
from ntp_dsl.dynamic.trial_traces import TrialTraces
from ntp_dsl.language.diagnostics.diagnostics import Diagnostic, Note, NtpError
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
from ntp_dsl.worlds.catalogue import lacking, make_world, misdeclared
from ntp_dsl.worlds.kinematic import KinematicWorld
from ntp_dsl.worlds.scenes import NoRoom, layout

OnStep = Callable[[str], None]
SCENES = 6  # in which apis and programs are tested: the smallest that the tasks draw
MAX_OBJECTS = 8  # of a scene for a library without tasks


def check_dynamically(
    registry: Registry,
    path: Path | None = None,
    seed: int = 0,
    on_step: OnStep = lambda _: None,
    traces: TrialTraces | None = None,
) -> list[Diagnostic]:
    """Return the diagnostics of a simulation, which is deterministic for a seed.

    None of them is at a place of a library that ships with the package, unless that is the one checked.

    Args:
        registry: where its functions in Python are not loaded, what needs them is noted as not executed.
        path: of the library; tasks and programs of the libraries that it uses are not tested.
        on_step: called with the name of each task or program before it is tested.
        traces: where to write those of trials that failed.
    """
    places = Places(registry, path)
    found = _Check(registry, path, seed, on_step, traces or TrialTraces(), places).run()
    return list(dict.fromkeys(places.owned(each, places.anywhere) for each in found))


@dataclass(frozen=True)
class _Check:
    """One simulation of a library."""

    registry: Registry
    path: Path | None
    seed: int
    on_step: OnStep
    traces: TrialTraces
    places: Places

    @cached_property
    def reach(self) -> Reach:
        return Reach(self.registry, lacking(KinematicWorld(), self.registry))

    def run(self) -> Iterator[Diagnostic]:
        """Yield what cannot be tested, and what is wrong with the rest."""
        yield from self.reach.not_executed()
        unfit = [Diagnostic("E112", *each) for each in misdeclared(KinematicWorld(), self.registry)]
        yield from unfit
        if unfit:
            return  # nothing that calls them can be tested
        runnable = self.reach.runnable()
        tasks = [task for task in runnable.tasks.values() if self.path in (None, task.name_span.path)]
        instances: list[Instance] = []
        sound: list[TaskDeclaration] = []
        for task in tasks:
            try:
                complete = replace(task, scene=_with_all_readings(task.scene, runnable))
                drawn = [draw(runnable, complete, np.random.default_rng((self.seed, n))) for n in range(3)]
                for each in (*drawn, _with_most_objects(runnable, complete)):
                    each.nominal_start(np.random.default_rng(self.seed))
            except NtpError as error:
                yield _impossible(task, error)
            else:
                instances += drawn
                sound.append(task)
        if not self.registry.tasks:
            instances = [_sample_of_all_types(runnable)]
        every = [each for each in instances if each.objects]  # nothing can be tested without objects
        every.sort(key=lambda instance: len(instance.objects))
        instances = _covering(every, runnable)
        if instances:
            yield from self._simulate(runnable, sound, instances, every)

    def _simulate(
        self,
        registry: Registry,
        tasks: Sequence[TaskDeclaration],
        instances: Sequence[Instance],
        every: Sequence[Instance],
    ) -> Iterator[Diagnostic]:
        """Yield what is wrong with apis, tasks and programs.

        Args:
            instances: in which apis are tested, and programs that no task calls.
            every: in which programs are tested, each in those whose task calls it.
        """
        world = make_world("kinematic", registry, exact=True)
        rollouts = ExpertRollouts(registry, world, self.seed, self.places, self.traces)
        self.on_step("apis")
        scene = self.places.scene(instances[0])
        try:
            found = list(check_contracts(registry, world, instances, self.seed, self.places, self.traces))
        except NtpError as error:  # a skill or predicate in Python failed, or a start has no room
            failed = self._failed(error, instances[0].task.name_span, [each.task for each in instances])
            yield self.places.owned(failed, scene)
            return
        untested = [each for each in found if each.code == "N603"]
        yield from (self.places.owned(each, scene) for each in found if each not in untested)
        if any(each.severity == "error" for each in found):
            yield from untested
            return  # the tests below rely on the apis' contracts
        steps = [(task.name, _home(task), partial(rollouts.check_task, task)) for task in tasks]
        steps += [
            (
                program.name,
                program.span,
                partial(
                    rollouts.check_program, program, _calling(program.name, every, registry) or instances
                ),
            )
            for program in registry.programs.values()
            if not program.takes_list and self.path in (None, program.span.path)
        ]
        is_sound = True
        for name, home, step in steps:
            self.on_step(name)
            own = [task for task in tasks if task.name == name]
            try:
                for each in step():
                    is_sound &= each.severity != "error"
                    yield self.places.owned(each, home)
            except NtpError as error:
                failed = self._failed(error, self.reach.place(name) or NOWHERE, own or tasks)
                is_sound = False
                yield self.places.owned(failed, home)
        tried = {registry.apis[name].span for name in rollouts.called & registry.apis.keys()}
        yield from (each for each in untested if each.span not in tried)
        if is_sound:
            run = (task.run.callee for task in tasks if task.run is not None)
            yield from rollouts.unused_lines({name for each in run for name in registry.called_by(each)})

    def _failed(self, error: NtpError, place: Span, tasks: Sequence[TaskDeclaration]) -> Diagnostic:
        """Return a diagnostic at the call or declaration that raised the error; at `place` where unknown.

        Args:
            tasks: in whose scenes it was raised.
        """
        if isinstance(error, NoGoal | NoRoom):
            group = error.group if isinstance(error, NoRoom) else ""
            meant = [task for task in tasks if not group or group in {each.name for each in task.scene}]
            if meant:
                return _impossible(meant[0], error)
        location, message = None, str(error)
        if isinstance(error, PythonFault | UndeclaredCall):
            location = self.reach.place(error.name)
        if isinstance(error, OutOfRange) and error.span.path:
            location, message = error.span, error.message
        notes = tuple(map(Note, getattr(error, "__notes__", ())))
        return Diagnostic("E607", message, location or place, notes)


def _calling(name: str, instances: Sequence[Instance], registry: Registry) -> list[Instance]:
    """Return a few instances whose program calls another one, directly or not."""
    return [each for each in instances if name in registry.called_by(each.program)][:SCENES]


def _covering(instances: Sequence[Instance], registry: Registry) -> list[Instance]:
    """Return a few instances: the first, and for each type that an api takes one that has such objects."""
    chosen = list(instances[:SCENES])
    for needed in {parameter.type: None for api in registry.apis.values() for parameter in api.parameters}:
        if needed in registry.parents and not any(_has(each, needed, registry) for each in chosen):
            chosen += [each for each in instances if _has(each, needed, registry)][:1]
    return chosen


def _has(instance: Instance, type_name: str, registry: Registry) -> bool:
    return any(registry.is_a(obj.type, type_name) for obj in instance.objects)


def _home(task: TaskDeclaration) -> Span:
    return task.run.span if task.run is not None else task.name_span


def _with_most_objects(registry: Registry, task: TaskDeclaration) -> Instance:
    """Return the fullest scene of a task, without a goal."""
    laid = layout(registry, task)
    return Instance(task, laid.objects, (), "", (), starts=laid.starts)


def _sample_of_all_types(registry: Registry) -> Instance:
    """Return a scene for a library without tasks: a few objects of every leaf type."""
    inherited = set(registry.parents.values())
    leaves = [name for name in registry.parents if name not in inherited and registry.is_a(name, "Place")]
    types = [name for name in leaves if name not in registry.constants.values()]
    scene = tuple(SceneGroup(name, max(2, MAX_OBJECTS // len(types)), TypeName(name)) for name in types)
    objects = layout(registry, TaskDeclaration("", scene=_with_all_readings(scene, registry))).objects
    return Instance(TaskDeclaration(""), objects, (), "", ())


def _with_all_readings(scene: tuple[SceneGroup, ...], registry: Registry) -> tuple[SceneGroup, ...]:
    """Return the scene with values for all readings of its objects.

    A program that is tested in the scene may need readings that the task leaves out.
    """
    readings = [
        each
        for each in registry.predicates.values()
        if each.result is not None and each.body is None and each.by is None and len(each.parameters) == 1
    ]

    def complete(group: SceneGroup) -> SceneGroup:
        given = {detail.name for detail in group.details}
        missing = tuple(
            Detail(each.name, _values(each.result, registry))
            for each in readings
            if each.name not in given and registry.is_a(group.type.name, each.parameters[0].type.name)
        )
        return replace(group, details=(*group.details, *missing))

    return tuple(map(complete, scene))


def _values(result: TypeName | None, registry: Registry) -> tuple[Setting, ...]:
    members = registry.enums.get(result.name if result else "", ())
    return tuple(map(Name, members)) or (Number(0.0), Number(1.0))


def _impossible(task: TaskDeclaration, error: NtpError) -> Diagnostic:
    if isinstance(error, NoGoal) and task.goal is not None:
        return Diagnostic("E608", f"no goal of '{task.name}' can be drawn: {error}", task.goal.span)
    group = error.group if isinstance(error, NoRoom) else ""
    spans = {each.name: each.span for each in task.scene}
    place = spans.get(group) or next(iter(spans.values()), task.name_span)
    return Diagnostic("E608", f"no scene of '{task.name}' can be made: {error}", place)
