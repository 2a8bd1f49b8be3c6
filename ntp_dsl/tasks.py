"""Tasks: a scene and a goal, drawn from what a library declares or read from a file."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ntp_dsl.language.diagnostics import NtpError
from ntp_dsl.language.syntax import Name, Sampler, TaskDeclaration
from ntp_dsl.registry import Registry
from ntp_dsl.state import Literal, State
from ntp_dsl.task_files import TaskFileEntry, read_tasks
from ntp_dsl.world import Argument, Observation, Record, Thing
from ntp_dsl.worlds.scenes import CUBE, declared_things, group_names, with_furniture

Goal = tuple[Record, ...]
Configuration = frozenset[tuple[str, str]]


@dataclass(frozen=True)
class Instance:
    """One task to carry out: its things, the goal that was drawn, and the root call."""

    task: TaskDeclaration
    things: tuple[Thing, ...]
    goal: Goal
    program: str
    arguments: tuple[Argument, ...]
    name: str = ""

    def literals(self, registry: Registry, observation: Observation) -> list[Literal]:
        """What success asks for, spelt out."""
        return State(registry, observation).literals(self.task.success, {"goal": self.goal})


def find_task(registry: Registry, name: str) -> TaskDeclaration:
    if name not in registry.tasks:
        known = ", ".join(registry.tasks) or "none"
        raise NtpError(f"no task is called '{name}'; library '{registry.name}' declares: {known}")
    return registry.tasks[name]


def draw(registry: Registry, task: TaskDeclaration, rng: np.random.Generator) -> Instance:
    """A goal by the task's own sampler."""
    things = declared_things(registry, task)
    assert task.goal is not None
    names = group_names(task)
    groups = [names[group] for group in task.goal.groups]
    return instance(task, things, SAMPLERS[task.goal.name](task.goal, groups, rng))


def from_file(registry: Registry, task: TaskDeclaration, path: Path) -> list[Instance]:
    """The tasks of a file (ours, or the paper's authors'), as instances of a declared task."""
    found = []
    for entry in read_tasks(path):
        _check_things(registry, entry, path)
        goal = tuple(
            Record("Placement", (("item", item), ("support", support)))
            for item, support in entry.goal
        )
        found.append(instance(task, with_furniture(registry, entry.things), goal, entry.id))
    return found


def _check_things(registry: Registry, entry: TaskFileEntry, path: Path) -> None:
    """A file's things must be such that a hand can stack them, and its goal such that it can be built."""
    where = f"{path}: {entry.id}"
    for thing in entry.things:
        if thing.type not in registry.parents:
            raise NtpError(f"{where}: library '{registry.name}' has no type '{thing.type}'")
        if thing.name in registry.constants:
            raise NtpError(f"{where}: '{thing.name}' is a constant of library '{registry.name}'")
        if thing.size != (CUBE, CUBE, CUBE):
            raise NtpError(f"{where}: expected cubes of {CUBE} m, found '{thing.name}' of {thing.size}")
    supports = dict(entry.goal)
    for item in supports:
        below, seen = item, {item}
        while (below := supports.get(below, "")) and below not in seen:
            seen.add(below)
        if below:
            raise NtpError(f"{where}: the goal goes round in a circle at '{below}'")


def instance(
    task: TaskDeclaration, things: tuple[Thing, ...], goal: Goal, name: str = ""
) -> Instance:
    assert task.run is not None
    arguments = tuple(
        goal if isinstance(term, Name) and term.id == "goal" else str(getattr(term, "id", term))
        for term in task.run.arguments
    )
    return Instance(task, things, goal, task.run.callee, arguments, name or task.name)


def towers(sampler: Sampler, groups: Sequence[Sequence[str]], rng: np.random.Generator) -> Goal:
    """Towers of the things of a group: so many placements, the tallest tower of such a height."""
    options = {option.name: (option.low, option.high) for option in sampler.options}
    names = [name for group in groups for name in group]
    low, high = options.get("height", (2, 4))
    fewest, most = options.get("placements", (1, len(names) - 1))
    placements = int(rng.choice(_possible(len(names), fewest, most, low, high)))
    heights = _heights(len(names), placements, low, high, rng)
    shuffled = [names[index] for index in rng.permutation(len(names))]
    goal: list[Record] = []
    for height in heights:
        tower, shuffled = shuffled[:height], shuffled[height:]
        for support, item in zip(tower, tower[1:], strict=False):
            goal.append(Record("Placement", (("item", item), ("support", support))))
    return tuple(goal)


def _possible(things: int, fewest: int, most: int, low: int, high: int) -> list[int]:
    counts = [n for n in range(fewest, most + 1) if _partitions(things, n, low, high)]
    if not counts:
        raise NtpError(
            f"no goal has {fewest}..{most} placements in towers of {low}..{high} out of {things} things"
        )
    return counts


def _heights(
    things: int, placements: int, low: int, high: int, rng: np.random.Generator
) -> list[int]:
    partitions = _partitions(things, placements, low, high)
    chosen = list(partitions[int(rng.integers(len(partitions)))])
    return [chosen[index] for index in rng.permutation(len(chosen))]


def _partitions(things: int, placements: int, low: int, high: int) -> list[tuple[int, ...]]:
    """Tower heights that use so many placements and no more things, the tallest in low..high."""

    def split(left: int, cap: int) -> list[tuple[int, ...]]:
        if left == 0:
            return [()]
        return [
            (first + 1, *rest)
            for first in range(min(left, cap), 0, -1)
            for rest in split(left - first, first)
        ]

    fits = (p for p in split(placements, high - 1) if sum(p) <= things)
    return [partition for partition in fits if max(partition) >= low]


SAMPLERS: Mapping[str, Callable[[Sampler, Sequence[Sequence[str]], np.random.Generator], Goal]] = {
    "towers": towers,
}


def end_configuration(goal: Goal) -> Configuration:
    return configuration((placement["item"], placement["support"]) for placement in goal)


def configuration(pairs: Iterable[tuple[str, str]]) -> Configuration:
    """Labelled: which thing ends up on which, by the numbers at the end of their names."""
    return frozenset((_number(item), _number(support)) for item, support in pairs)


def _number(name: str) -> str:
    return name.rsplit("_", 1)[-1]
