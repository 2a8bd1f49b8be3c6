"""The border: a learned program is given a demonstration; no goal, list, success test or truth."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from functools import cached_property
from typing import Any, NoReturn

import pytest
from one_core_samples import is_built, library, lists, the_model, without_numbers

from ntp_dsl.api import Episode, Task, demonstrate, draw, run
from ntp_dsl.core.models import OneCoreModel
from ntp_dsl.core.policy import OneShotPolicy
from ntp_dsl.demonstrations.demonstration import UNKNOWN, Demonstration
from ntp_dsl.language.registry import Registry
from ntp_dsl.policies.protocol import Barred, Choice, Frame, Policy
from ntp_dsl.semantics.observation import Argument
from ntp_dsl.worlds.catalogue import make_world
from ntp_dsl.worlds.protocol import UNDISTURBED, Disturbances

FIXED_SCENES = ["block_stacking", "seating", "line_up", "sandwiches", "exchange"]
FEW, MANY = 3, 40


class Touched(Exception):
    """A policy reached for what it is not given."""


def _refuse(*_: Any) -> NoReturn:
    raise Touched


class Untouchable(tuple[Any, ...]):
    """A list that says nothing of what is in it, not even how much."""

    __len__ = __iter__ = __getitem__ = __contains__ = __eq__ = __ne__ = __hash__ = __repr__ = _refuse  # type: ignore[assignment]
    __add__ = __mul__ = __lt__ = __le__ = __gt__ = __ge__ = index = count = __reduce_ex__ = _refuse  # type: ignore[assignment]


class UntouchableTasks(Mapping[str, Any]):
    """The declarations of tasks: their success tests and samplers."""

    def __getitem__(self, name: str) -> Any:
        raise Touched

    def __iter__(self) -> Iterator[str]:
        raise Touched

    def __len__(self) -> int:
        raise Touched


class OnlyObserved:
    """A world of which a policy can ask nothing but what can be observed."""

    def __init__(self, world: Any) -> None:
        self._observe = world.observe

    def observe(self) -> Any:
        return self._observe()

    def __getattr__(self, name: str) -> NoReturn:
        raise Touched(name)


class Trapped:
    """A policy that is given lists and a world which raise where they say too much."""

    def __init__(self, policy: Policy) -> None:
        self._policy = policy

    def root(self, program: str, arguments: tuple[Argument, ...]) -> Frame:
        given = tuple(Untouchable(each) if isinstance(each, tuple) else each for each in arguments)
        return self._policy.root(program, given)

    def decide(self, frame: Frame, world: Any, barred: Barred = frozenset()) -> Choice:
        return self._policy.decide(frame, OnlyObserved(world), barred)  # type: ignore[arg-type]


def without_tasks(registry: Registry) -> Registry:
    return replace(registry, tasks=UntouchableTasks())  # type: ignore[arg-type]


def trapped(task: Task, demonstration: Demonstration) -> Trapped:
    model = the_model(task.registry, task.instance.program)
    blind = OneCoreModel(model.core, without_tasks(task.registry), model.dispatch)
    return Trapped(blind.shown(replace(demonstration, origin=UNKNOWN)))


def two_goals(name: str, seed: int) -> tuple[Task, Task]:
    """Return a task, and the same scene and call with a goal that another task of the library has."""
    declared = draw(library(name), name, seed)
    literals = facts_of(declared)
    for other in range(seed + 1, seed + 100):
        goal = draw(library(name), name, other).goal
        another = replace(declared, instance=declared.instance.with_goal(goal))
        scene = another.scene()
        new = not literals <= facts_of(another) and not another.instance.holds_in(another.registry, scene)
        if new and another.instance.shown_by(another.registry, scene) == len(goal):
            return declared, another
    raise AssertionError("all goals are alike")


def facts_of(task: Task) -> set[str]:
    world = make_world("kinematic", task.registry)
    world.reset(task.scene(), 0)
    return {str(fact) for fact in task.instance.literals(task.registry, world.truth())}


@pytest.mark.parametrize("name", FIXED_SCENES)
def test_what_was_shown_gets_built_and_not_what_was_declared(name: str, soak: bool) -> None:
    """Scene and call are declared for one goal, and the demonstration is of another."""
    for seed in range(MANY if soak else FEW):
        declared, shown = two_goals(name, seed)
        demonstration = demonstrate(shown).demonstration
        world = make_world("kinematic", declared.registry)
        episode = run(declared, trapped(declared, demonstration), world)
        built = is_built(shown.registry, shown.instance, world)
        assert built, f"seed {seed}: {episode.run}"
        assert not episode.success, f"seed {seed}"


@pytest.mark.parametrize("name", FIXED_SCENES)
def test_the_declared_goal_changes_no_decision(name: str) -> None:
    declared, shown = two_goals(name, 5)
    demonstration = demonstrate(shown).demonstration
    one, other = (calls(run(task, trapped(task, demonstration))) for task in (declared, shown))
    assert one == other


def calls(episode: Episode) -> list[str]:
    return [
        str((each.name, without_numbers(lists(each.arguments)), each.outcome))
        for each in episode.trace.calls[1:]
    ]


@pytest.mark.parametrize("name", ["serving", "kitting", "set_the_table", "table_cleanup", "village"])
def test_nothing_else_is_reached_for_in_other_domains_either(name: str) -> None:
    task = draw(library(name), name, 2)
    assert run(task, trapped(task, demonstrate(task).demonstration)).success


def test_nothing_else_is_reached_for_under_noise_and_slips() -> None:
    task = draw(library("block_stacking"), "block_stacking", 4)
    policy = trapped(task, demonstrate(task).demonstration)
    assert run(task, policy, disturbances=Disturbances(slips=0.25, noise=0.002)).success


# The trap itself


class CountsItsList(OneShotPolicy):
    def root(self, program: str, arguments: tuple[Argument, ...]) -> Frame:
        for each in arguments:
            if isinstance(each, tuple):
                len(each)
        return super().root(program, arguments)


class LooksAtTheTruth(OneShotPolicy):
    def decide(self, frame: Frame, world: Any, barred: Barred = frozenset()) -> Choice:
        return self.choose(frame, world.truth(), barred)


class ReadsTheSuccessTest(OneShotPolicy):
    @cached_property
    def success(self) -> Any:
        return next(iter(self.source.registry.tasks.values())).success  # type: ignore[attr-defined]

    def decide(self, frame: Frame, world: Any, barred: Barred = frozenset()) -> Choice:
        assert self.success is not None
        return super().decide(frame, world, barred)


@pytest.mark.parametrize("cheat", [CountsItsList, LooksAtTheTruth, ReadsTheSuccessTest])
def test_a_policy_that_reaches_for_more_is_caught(cheat: type[OneShotPolicy]) -> None:
    task = draw(library("block_stacking"), "few_placements", 1)
    honest = trapped(task, demonstrate(task).demonstration)._policy
    assert isinstance(honest, OneShotPolicy)
    cheating = Trapped(cheat(honest.source, honest._dispatcher))
    with pytest.raises(Touched):
        run(task, cheating, disturbances=UNDISTURBED)


def test_a_policy_that_is_told_its_lists_is_caught() -> None:
    task = draw(library("block_stacking"), "few_placements", 1)
    with pytest.raises(Touched):
        run(task, Trapped(the_model(task.registry, task.instance.program).told()))


@pytest.mark.parametrize(
    "touch",
    [
        len,
        list,
        tuple,
        set,
        str,
        hash,
        lambda each: [*each],
        lambda each: each[0],
        lambda each: "x" in each,
        lambda each: each == (),
        lambda each: () == each,
        lambda each: each + (),
    ],
)
def test_an_untouchable_list_cannot_be_looked_at(touch: Any) -> None:
    with pytest.raises(Touched):
        touch(Untouchable(["block_0"]))
