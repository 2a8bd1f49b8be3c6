"""Tasks: a scene and a goal, drawn from what a library declares or read from a file."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import product
from pathlib import Path

import numpy as np

from ntp_dsl.language.checks.scenes import GOAL, named_objects
from ntp_dsl.language.diagnostics.diagnostics import NtpError
from ntp_dsl.language.diagnostics.spelling import nearest
from ntp_dsl.language.names.signatures import si
from ntp_dsl.language.registry import Parameter, Registry
from ntp_dsl.language.syntax.nodes import Atom, Expression, GivenGoal, Name, Number, TaskDeclaration
from ntp_dsl.language.syntax.visitors import free_names
from ntp_dsl.semantics.facts import Fact
from ntp_dsl.semantics.observation import TOO_WIDE, Argument, DeclaredFact, Observation, Record, SceneObject
from ntp_dsl.semantics.state import State
from ntp_dsl.semantics.value_checks import misfit, strays
from ntp_dsl.tasks.goal_samplers import Goal, Variation, draw_goal
from ntp_dsl.tasks.goal_text import Lists
from ntp_dsl.tasks.task_files import GoalRow, TaskFileEntry, read_tasks
from ntp_dsl.worlds.perturbed_starts import STRAIGHT, perturbed_start
from ntp_dsl.worlds.protocol import Scene
from ntp_dsl.worlds.scenes import LIFTED, Start, layout, with_furniture
from ntp_dsl.worlds.starts import nominal_start

Configuration = frozenset[tuple[str, str]]
PLACEMENT = "Placement"  # the record of the standard library: an item, and what it goes on


@dataclass(frozen=True)
class Instance:
    """One task to carry out: its objects, the goal that was drawn, and the root call."""

    task: TaskDeclaration
    objects: tuple[SceneObject, ...]
    goal: Goal
    program: str
    arguments: tuple[Argument, ...]
    name: str = ""
    bindings: Mapping[str, Argument] = field(default_factory=dict)  # goal, and the groups by name
    starts: Mapping[str, Start] = field(default_factory=dict)
    facts: frozenset[DeclaredFact] = frozenset()  # of the state, that hold at the start

    @property
    def is_judged(self) -> bool:
        """Return whether success can be told: a goal is known, or none is needed."""
        return bool(self.goal) or self.task.goal is None

    def literals(self, registry: Registry, observation: Observation) -> list[Fact]:
        """Return the facts that the success condition consists of."""
        return State(registry, observation).literals(self.task.success, self.bindings)

    def holds_in(self, registry: Registry, scene: Scene) -> bool:
        """Return whether the goal holds in a scene, with an open hand that is out of the way."""
        seen = scene.seen
        state = State(registry, seen)
        return all(state.holds(fact) for fact in self.literals(registry, seen))

    def shown_by(self, registry: Registry, scene: Scene) -> int:
        """Return how many parts of the goal a demonstration from a scene shows: they do not hold yet.

        Parts are the goal's elements; where there are none, it is one part.
        """
        seen = scene.seen
        state = State(registry, seen)
        if not self.goal:
            return int(not self.holds_in(registry, scene))
        others = {*self._said_of((), registry, state)}
        rows = (self._said_of((row,), registry, state) for row in self.goal)
        return sum(any(not state.holds(fact) for fact in facts if fact not in others) for facts in rows)

    @property
    def parts(self) -> int:
        """Return how many parts of the goal there are."""
        return len(self.goal) or 1

    def _said_of(self, goal: Goal, registry: Registry, state: State) -> list[Fact]:
        """Return what success says of a goal; where it is judged by name, what the program achieves of it."""
        if self.task.success is not None and GOAL in free_names(self.task.success):
            return state.literals(self.task.success, {**self.bindings, GOAL: goal})
        program = registry.programs[self.program]
        return state.literals(program.achieves, program.bind(self._called_with(goal)))

    def _called_with(self, goal: Goal) -> tuple[Argument, ...]:
        """Return the root's arguments with another list in the place of the goal."""
        return tuple(goal if each is self.goal else each for each in self.arguments)

    def with_goal(self, goal: Goal) -> Instance:
        """Return the same scene with another goal, which the root call gets as well."""
        arguments = self._called_with(goal)
        bindings = {**self.bindings, GOAL: goal}
        return replace(self, goal=goal, arguments=arguments, bindings=bindings)

    def nominal_start(self, rng: np.random.Generator) -> Scene:
        """Return a scene with all objects apart, where the task lets them start."""
        return self.in_state(nominal_start(self.objects, rng, self.starts))

    def perturbed_start(
        self, rng: np.random.Generator, in_hand: bool = True, straight: float = STRAIGHT
    ) -> Scene:
        """Return a scene with partial and wrong towers, buried objects, at random one in the hand."""
        return self.in_state(perturbed_start(self.objects, rng, in_hand, self.starts, straight))

    def in_state(self, scene: Scene) -> Scene:
        """Return a scene in which those facts of the state hold that hold at the start."""
        return replace(scene, facts=self.facts)


def enough_primitives(instance: Instance) -> int:
    """Return a limit for runs: several times the primitives that any of the examples needs."""
    return max(400, 20 * len(instance.objects))


def as_told(registry: Registry, instance: Instance, lists: Lists, where: str) -> Instance:
    """Return an instance that runs with other lists.

    Args:
        where: they were told, for errors.

    Raises `NtpError` for an empty goal, and for placements that nobody can bring about together.
    """
    program = registry.programs[instance.program]
    told = tuple(
        lists[parameter.name] if parameter.is_list else value
        for parameter, value in zip(program.parameters, instance.arguments, strict=True)
    )
    for before, value in zip(instance.arguments, told, strict=True):
        if before is instance.goal:
            assert isinstance(value, tuple)
            goal = tuple(each for each in value if isinstance(each, Record))
            if not goal:
                raise NtpError(f"{where}: the goal is empty, so there is nothing to do")
            if goal[0].type == PLACEMENT:
                _check_rows(goal, where)
                _check_no_circle(goal, where)
            instance = instance.with_goal(goal)
    return replace(instance, arguments=told)


def find_task(registry: Registry, name: str) -> TaskDeclaration:
    """Return a declared task. Raises `NtpError`, with the declared tasks, for an unknown name."""
    if name in registry.tasks:
        return registry.tasks[name]
    meant = nearest(name, registry.tasks)
    guess = f"; did you mean '{meant}'?" if meant else "."
    if not registry.tasks:
        raise NtpError(f"no task is called '{name}': library '{registry.name}' declares none")
    width = max(map(len, registry.tasks))
    listing = "".join(
        f"\n  {task.name:{width}}  {' '.join(task.docstring.split())}".rstrip()
        for task in registry.tasks.values()
    )
    raise NtpError(f"no task is called '{name}'{guess} Library '{registry.name}' declares:{listing}")


def draw(
    registry: Registry,
    task: TaskDeclaration,
    rng: np.random.Generator,
    varied: Variation | None = None,
) -> Instance:
    """Draw a scene as the task declares it, and a goal by its sampler.

    Args:
        varied: ranges for `length`, `topology` and `semantics` in place of the declared ones.
    """
    laid = layout(registry, task, rng)
    goal: Goal = ()
    if isinstance(task.goal, GivenGoal):
        goal = _given(registry, task, task.goal)
    elif task.goal is not None:
        goal = draw_goal(registry, task.goal, laid, rng, varied)
    drawn = instance(task, laid.objects, goal, groups=laid.groups)
    facts = frozenset(fact for each in task.facts for fact in _facts(each, laid.groups))
    return replace(drawn, starts=laid.starts, facts=facts)


def _given(registry: Registry, task: TaskDeclaration, goal: GivenGoal) -> Goal:
    """Return the rows of a goal that is given."""
    name = goal.result.name if goal.result else _goal_record(registry, task)
    rows = (tuple(_value(term) for term in row.terms) for row in goal.rows)
    fields = [each.name for each in registry.records[name]]
    return tuple(Record(name, tuple(zip(fields, row, strict=True))) for row in rows)


def _facts(fact: Atom, groups: Mapping[str, Sequence[str]]) -> Iterator[DeclaredFact]:
    """Yield the facts that are stated, one for each object of a group that is named."""
    names = (str(_value(term)) for term in fact.arguments)
    for each in product(*(groups.get(name, [name]) for name in names)):
        yield DeclaredFact(fact.predicate, each)


def from_file(registry: Registry, task: TaskDeclaration, path: Path) -> list[Instance]:
    """Return the tasks of a file (ours, or the paper's authors') as instances of a declared task.

    Raises `NtpError` for objects of types that the library lacks, and for goals that the task does not have.
    """
    record = _goal_record(registry, task)
    found = []
    for entry in read_tasks(path):
        where = f"{path}: {entry.id}"
        _check_objects(registry, entry, where)
        goal = tuple(_record(registry, record, row, entry, where) for row in entry.goal)
        _check_rows(goal, where)
        _check_no_circle(goal, where)
        _check_named(registry, task, entry, where)
        facts = frozenset(fact for each in task.facts for fact in _facts(each, {}))
        made = instance(task, with_furniture(registry, entry.objects), goal, entry.id)
        found.append(replace(made, facts=facts))
    return found


def _check_named(registry: Registry, task: TaskDeclaration, entry: TaskFileEntry, where: str) -> None:
    """Raise `NtpError` where a file lacks what the task names: in what it runs, as success, at the start."""
    assert task.run is not None
    parts = [*task.run.arguments, *([task.success] if task.success else []), *task.facts]
    of_scene = {*dict(named_objects(task)), *(group.name for group in task.scene)}
    named = {name for part in parts for name in free_names(part)} & of_scene
    missing = [each for each in sorted(named) if each not in entry.names]
    if groups := [each for each in missing if each not in dict(named_objects(task))]:
        raise NtpError(
            f"{where}: task '{task.name}' names its group {groups[0]}, and a file has no groups: "
            "name objects, or all of a type, in the task"
        )
    if missing:
        raise NtpError(
            f"{where}: the file lacks {', '.join(missing)}, which task '{task.name}' names: call objects so"
        )


def _goal_record(registry: Registry, task: TaskDeclaration) -> str:
    """Return the record that the task's program takes a list of."""
    assert task.run is not None
    parameters = registry[task.run.callee].parameters
    for parameter, term in zip(parameters, task.run.arguments, strict=True):
        if isinstance(term, Name) and term.id == GOAL and parameter.type in registry.records:
            return parameter.type
    raise NtpError(f"the program of task '{task.name}' takes no list of records: its goals are not for files")


def _record(registry: Registry, name: str, row: GoalRow, entry: TaskFileEntry, where: str) -> Record:
    """Return a row of a file as a record, its fields in the declared order."""
    fields = registry.records[name]
    if {each.name for each in fields} != row.keys():
        names = ", ".join(each.name for each in fields)
        raise NtpError(f"{where}: expected {name} with the fields {names}, found {', '.join(row)}")
    for each in fields:
        _check_value(registry, each, row[each.name], entry, where)
    return Record(name, tuple((each.name, row[each.name]) for each in fields))


def _check_value(
    registry: Registry, field: Parameter, value: str | float, entry: TaskFileEntry, where: str
) -> None:
    """Raise `NtpError` for a value of a goal that is not of its field's type, or cannot be moved."""
    types = dict(registry.constants) | {obj.name: obj.type for obj in entry.objects}
    if expected := misfit(registry, field, value, types) or strays(field, value):
        names = (
            f" ({', '.join(entry.names)})" if value not in types and field.type in registry.parents else ""
        )
        raise NtpError(f"{where}: expected {expected}{names} for '{field.name}' of the goal; found {value!r}")
    still = [obj for obj in entry.objects if obj.name == value and not obj.movable]
    if still and registry.is_a(field.type, LIFTED):
        raise NtpError(
            f"{where}: the goal moves '{value}', which is fixed or wider than {TOO_WIDE:g} m; "
            "move another object, or change this one"
        )


def _check_rows(goal: Goal, where: str) -> None:
    """Raise `NtpError` for a row that is there twice, and for an item that is to be placed twice."""
    seen: set[object] = set()
    for row in goal:
        key = row["item"] if row.type == PLACEMENT else row
        if key in seen:
            raise NtpError(f"{where}: the goal has a second row for {key}; leave out one of them")
        seen.add(key)


def _check_objects(registry: Registry, entry: TaskFileEntry, where: str) -> None:
    for obj in entry.objects:
        if obj.type not in registry.parents:
            raise NtpError(f"{where}: library '{registry.name}' has no type '{obj.type}'")
        if obj.name in registry.constants:
            raise NtpError(f"{where}: '{obj.name}' is a constant of library '{registry.name}'")


def _check_no_circle(goal: Goal, where: str) -> None:
    """Raise `NtpError` for a goal in which an object stands, through others, on itself."""
    supports = {str(row.fields[0][1]): str(row.fields[-1][1]) for row in goal}
    for item in supports:
        below, seen = item, {item}
        while (below := supports.get(below, "")) and below not in seen:
            seen.add(below)
        if below:
            raise NtpError(f"{where}: the goal goes round in a circle at '{below}'")


def instance(
    task: TaskDeclaration,
    objects: tuple[SceneObject, ...],
    goal: Goal,
    name: str = "",
    groups: Mapping[str, Sequence[str]] | None = None,
) -> Instance:
    """Return the root call of a task, with its goal, groups, constants and numbers filled in."""
    assert task.run is not None
    bindings: dict[str, Argument] = {GOAL: goal}
    single = {group.name for group in task.scene if group.is_single}  # an object, and no list
    bindings |= {name: tuple(names) for name, names in (groups or {}).items() if name not in single}
    arguments = tuple(_argument(term, bindings) for term in task.run.arguments)
    return Instance(task, objects, goal, task.run.callee, arguments, name or task.name, bindings)


def _argument(term: Expression, bindings: Mapping[str, Argument]) -> Argument:
    value = _value(term)
    return bindings.get(value, value) if isinstance(value, str) else value


def _value(term: Expression) -> str | float:
    if isinstance(term, Number):
        value = si(term)
        assert value is not None
        return value
    assert isinstance(term, Name), "the checker allows names and numbers here"
    return term.id


def end_configuration(goal: Goal) -> Configuration:
    """Return the end configuration of a goal."""
    return configuration(dict(row.fields) for row in goal)


def configuration(rows: Iterable[GoalRow]) -> Configuration:
    """Return which object ends up where, by the numbers at the end of names: first and last of a row."""
    values = (list(map(str, row.values())) for row in rows)
    return frozenset((_number(row[0]), _number(row[-1])) for row in values)


def _number(name: str) -> str:
    return name.rsplit("_", 1)[-1]
