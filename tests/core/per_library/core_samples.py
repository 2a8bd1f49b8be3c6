"""What the core's tests share: the shipped core, a demonstration, and states to ask about."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ntp_dsl.datasets.recording import RecordedDemonstration, demonstrate
from ntp_dsl.demonstrations.demonstration import Demonstration
from ntp_dsl.demonstrations.queries import Query
from ntp_dsl.language.registry import Registry
from ntp_dsl.policies.expert import Expert
from ntp_dsl.semantics.observation import Observation, SceneObject
from ntp_dsl.tasks.instances import Instance, draw, find_task
from ntp_dsl.worlds.kinematic import KinematicWorld
from ntp_dsl.worlds.perturbed_starts import perturbed_start


def shown_task(registry: Registry, seed: int) -> tuple[Instance, RecordedDemonstration]:
    """Return a task of the library, demonstrated in the kinematic world."""
    task = find_task(registry, "block_stacking")
    instance = draw(registry, task, np.random.default_rng(seed))
    shown = demonstrate(registry, Expert(registry), KinematicWorld(), instance, seed)
    assert isinstance(shown, RecordedDemonstration)
    return instance, shown


def perturbed_state(instance: Instance, seed: int) -> Observation:
    world = KinematicWorld()
    world.reset(perturbed_start(instance.objects, np.random.default_rng(seed)), seed)
    return world.observe()


def queries(registry: Registry, seed: int) -> list[Query]:
    """One about each program, in a state that has nothing to do with the demonstration's."""
    instance, shown = shown_task(registry, seed)
    state = perturbed_state(instance, seed)
    blocks = [obj.name for obj in instance.objects[:2]]
    found = []
    for name, program in registry.programs.items():
        arguments = tuple(p for p in program.parameters if not p.is_list)
        scope = (0, len(shown.demonstration)) if program.takes_list else None
        found.append(Query(name, tuple(blocks[: len(arguments)]), scope, state, shown.demonstration))
    return found


def renamed(query: Query, names: dict[str, str]) -> Query:
    """Return the same question with its objects called otherwise."""
    seen = query.observation
    return replace(
        query,
        arguments=tuple(names[str(name)] for name in query.arguments),
        observation=replace(
            seen,
            objects=_renamed_objects(seen.objects, names),
            positions={names[name]: place for name, place in seen.positions.items()},
        ),
        demonstration=replace(
            query.demonstration, objects=_renamed_objects(query.demonstration.objects, names)
        ),
    )


def reordered(query: Query, seed: int) -> Query:
    """Return the same question with its objects listed otherwise, here and in the demonstration."""
    rng = np.random.default_rng(seed)
    count = len(query.observation.objects)
    shown = query.demonstration
    order = [int(index) for index in rng.permutation(count)]
    return replace(
        query,
        observation=query.observation.permuted(tuple(int(i) for i in rng.permutation(count))),
        demonstration=Demonstration(
            tuple(shown.objects[index] for index in order),
            shown.times,
            shown.closed,
            shown.grippers,
            shown.positions[:, order],
        ),
    )


def _renamed_objects(objects: tuple[SceneObject, ...], names: dict[str, str]) -> tuple[SceneObject, ...]:
    return tuple(replace(obj, name=names[obj.name]) for obj in objects)
