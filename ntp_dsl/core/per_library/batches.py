"""From queries and answers to padded tensors."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
import torch
from torch import Tensor

from ntp_dsl.core.per_library import keyframes
from ntp_dsl.core.per_library.memory import Memory
from ntp_dsl.demonstrations.demonstration import Demonstration, Scope
from ntp_dsl.demonstrations.queries import Answer, Query
from ntp_dsl.semantics.observation import Observation, SceneObject

IGNORE = -100
NOTHING = -1


@dataclass(frozen=True)
class Frames:
    """Parts of demonstrations, padded: what each of `specs` shows."""

    positions: Tensor  # (specs, frames, things, 3) relative to the gripper
    closed: Tensor  # (specs, frames)
    mask: Tensor  # (specs, frames)
    types: Tensor  # (specs, things, types) multi-hot
    things: Tensor  # (specs, things) which are there
    still: Tensor  # (specs, things) which of these never move; all of them where every one may
    rows: Tensor  # (specs,) the program that is shown
    typed: Tensor  # (specs,) 1 where events are told apart by types as well


@dataclass(frozen=True)
class States:
    """The present, padded: what each query sees and was called with."""

    positions: Tensor  # (queries, things, 3) relative to the gripper
    closed: Tensor  # (queries,)
    types: Tensor  # (queries, things, types)
    things: Tensor  # (queries, things)
    arguments: Tensor  # (queries, things, arity) one-hot
    values: Tensor  # (queries, value_arity * choices) members one-hot, and numbers scaled
    rows: Tensor  # (queries,)
    spec: Tensor  # (queries,) index into `Frames`, or -1 without a scope


@dataclass(frozen=True)
class Answers:
    """Right answers as indices; IGNORE where a head is not asked."""

    slot: Tensor  # (queries,) IGNORE at an end
    end: Tensor  # (queries,) 1 where the program returns
    start_frame: Tensor  # (queries,) the last before the callee's scope; NOTHING where all is done
    last_frame: Tensor  # (queries,) of the callee's scope
    lost: Tensor  # (queries,) 1 where the callee's scope is none: a recovery that was never shown
    pointers: Tensor  # (queries, arity)
    candidates: Tensor  # (queries, arity, things) of the declared types
    members: Tensor  # (queries, value_arity) of the enumerations among its values
    numbers: Tensor  # (queries, value_arity) scaled; NaN where there is none
    choosable: Tensor  # (queries, value_arity, choices - 1) which members there are
    weight: Tensor  # (queries,)
    told: Tensor  # (queries,) whether the decision is made from the true start, or from what was read


@lru_cache(maxsize=4096)
def type_rows(memory: Memory, things: tuple[SceneObject, ...]) -> Tensor:
    """(things, types): a thing is of its type and of all the ancestors of it."""
    return torch.tensor([[memory.takes(t.type, name) for name in memory.types] for t in things]).float()


def states(memory: Memory, queries: Sequence[Query], specs: Sequence[int]) -> States:
    count = max(len(query.observation.objects) for query in queries)
    size = len(queries)
    positions = torch.zeros(size, count, 3)
    types = torch.zeros(size, count, len(memory.types))
    there = torch.zeros(size, count, dtype=torch.bool)
    arguments = torch.zeros(size, count, memory.arity)
    values = torch.zeros(size, memory.value_arity, memory.choices)
    for index, query in enumerate(queries):
        seen = query.observation
        relative, visible = relative_positions(seen)
        n = len(seen.objects)
        positions[index, :n] = relative
        there[index, :n] = visible
        types[index, :n] = type_rows(memory, tuple(seen.objects))
        names = [thing.name for thing in seen.objects]
        signature = memory.signature(query.program)
        objects, others = signature.split(query.arguments)
        for place, name in enumerate(objects):
            arguments[index, names.index(name), place] = 1.0
        for place, (value, given) in enumerate(zip(signature.values, others, strict=True)):
            if value.members:
                values[index, place, value.members.index(str(given))] = 1.0
            else:
                values[index, place, -1] = value.scaled(float(given))
    return States(
        positions,
        torch.tensor([float(query.observation.closed) for query in queries]),
        types,
        there,
        arguments,
        values.flatten(1),
        torch.tensor([memory.index(query.program) for query in queries]),
        torch.tensor(list(specs)),
    )


def relative_positions(seen: Observation) -> tuple[Tensor, Tensor]:
    """(things, 3) minus the gripper's point, and which of them are there."""
    nowhere = seen.gripper
    points = np.array([seen.positions.get(thing.name, nowhere) for thing in seen.objects])
    visible = [thing.name in seen.positions for thing in seen.objects]
    relative = torch.from_numpy((points - np.array(seen.gripper)).astype(np.float32))
    return relative, torch.tensor(visible)


def frames(
    memory: Memory,
    parts: Sequence[tuple[Demonstration, Scope, str]],
    orders: Sequence[Sequence[str]] | None = None,
    things: int = 0,
) -> Frames:
    """Parts of demonstrations, padded.

    Args:
        orders: the things of each part as the present state lists them.
        things: pads to so many at least, as the states are padded that the parts are compared with.
    """
    shown = [keyframes.within(demonstration, scope) for demonstration, scope, _ in parts]
    length = max(map(len, shown))
    count = max(things, *(len(demonstration.objects) for demonstration, _, _ in parts))
    size = len(parts)
    positions = torch.zeros(size, length, count, 3)
    closed = torch.zeros(size, length)
    mask = torch.zeros(size, length, dtype=torch.bool)
    types = torch.zeros(size, count, len(memory.types))
    there = torch.zeros(size, count, dtype=torch.bool)
    still = torch.zeros(size, count, dtype=torch.bool)
    for index, (demonstration, _, _) in enumerate(parts):
        chosen, n = shown[index], len(demonstration.objects)
        span = len(chosen)
        order = _order(demonstration, orders[index] if orders else demonstration.names)
        seen = demonstration.relative[chosen][:, order]
        positions[index, :span, :n] = torch.from_numpy(seen)
        closed[index, :span] = torch.from_numpy(demonstration.closed[chosen].astype(np.float32))
        mask[index, :span] = True
        types[index, :n] = type_rows(memory, tuple(demonstration.objects[i] for i in order))
        there[index, :n] = True
        fixed = [not demonstration.objects[i].movable for i in order]
        still[index, :n] = torch.tensor(fixed) if any(fixed) else True
    rows = torch.tensor([memory.index(program) for _, _, program in parts])
    return Frames(positions, closed, mask, types, there, still, rows, torch.ones(size))


def answers(
    memory: Memory,
    queries: Sequence[Query],
    right: Sequence[Answer],
    weights: Sequence[float],
    things: int,
) -> Answers:
    size = len(queries)
    slot = torch.full((size,), IGNORE)
    start, last = torch.full((size,), IGNORE), torch.full((size,), IGNORE)
    pointers = torch.full((size, memory.arity), IGNORE)
    lost = torch.full((size,), IGNORE)
    members = torch.full((size, memory.value_arity), IGNORE)
    numbers = torch.full((size, memory.value_arity), float("nan"))
    choosable = torch.zeros(size, memory.value_arity, memory.choices - 1, dtype=torch.bool)
    for index, (query, answer) in enumerate(zip(queries, right, strict=True)):
        if answer.callee is None:
            start[index] = NOTHING if answer.done else IGNORE
            continue
        lost[index] = int(answer.scope is None)
        slot[index] = memory.row(query.program).callees.index(answer.callee)
        names = [thing.name for thing in query.observation.objects]
        signature = memory.signature(answer.callee)
        objects, others = signature.split(answer.arguments)
        for place, name in enumerate(objects):
            pointers[index, place] = names.index(name)
        for place, (value, given) in enumerate(zip(signature.values, others, strict=True)):
            if value.members:
                members[index, place] = value.members.index(str(given))
                choosable[index, place, : len(value.members)] = True
            else:
                numbers[index, place] = value.scaled(float(given))
        if query.scope is not None and answer.scope is not None:
            shown = keyframes.within(query.demonstration, query.scope)
            start[index] = keyframes.last_before(shown, answer.scope[0])
            last[index] = keyframes.last_before(shown, answer.scope[1])
    return Answers(
        slot,
        torch.tensor([float(answer.callee is None) for answer in right]),
        start,
        last,
        lost,
        pointers,
        _candidates(memory, queries, right, things),
        members,
        numbers,
        choosable,
        torch.tensor(list(weights), dtype=torch.float32),
        torch.ones(size, dtype=torch.bool),
    )


@lru_cache(maxsize=4096)
def candidate_rows(memory: Memory, callee: str, things: tuple[SceneObject, ...]) -> Tensor:
    """(arity, things): what each argument of the callee may point at."""
    rows = torch.zeros(memory.arity, len(things), dtype=torch.bool)
    for place, type_name in enumerate(memory.signature(callee).object_types):
        for index, thing in enumerate(things):
            rows[place, index] = memory.takes(thing.type, type_name)
    return rows


def _candidates(memory: Memory, queries: Sequence[Query], right: Sequence[Answer], things: int) -> Tensor:
    rows = torch.zeros(len(queries), memory.arity, things, dtype=torch.bool)
    for index, (query, answer) in enumerate(zip(queries, right, strict=True)):
        if answer.callee is not None:
            seen = query.observation.objects
            rows[index, :, : len(seen)] = candidate_rows(memory, answer.callee, tuple(seen))
    return rows


def _order(demonstration: Demonstration, names: Sequence[str]) -> list[int]:
    places = {name: index for index, name in enumerate(demonstration.names)}
    return [places[name] for name in names]
