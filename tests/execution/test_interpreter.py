"""The stack machine itself: what it lets a policy do again, and what it does not."""

from __future__ import annotations

from collections.abc import Callable
from math import dist

import numpy as np
import pytest

from ntp_dsl.execution.interpreter import Interpreter, Run
from ntp_dsl.execution.refusals import ROUNDS, TRIES, InVain, Refusals
from ntp_dsl.language.diagnostics.diagnostics import NtpError
from ntp_dsl.language.loader import load
from ntp_dsl.language.registry import Registry
from ntp_dsl.policies.protocol import Barred, Choice, Frame
from ntp_dsl.semantics.observation import Argument
from ntp_dsl.tasks.instances import draw, find_task
from ntp_dsl.traces.schema import Ending
from ntp_dsl.worlds.kinematic import KinematicWorld
from ntp_dsl.worlds.protocol import ACHIEVED, Failure, Outcome, World


class Stubborn:
    """A policy that makes the same call for ever, unless it is barred."""

    def __init__(self, wanted: dict[str, tuple[str, tuple[Argument, ...]]]) -> None:
        self.wanted = wanted
        self.asked: list[Barred] = []

    def root(self, program: str, arguments: tuple[Argument, ...]) -> Frame:
        return Frame(program, (), None)

    def decide(self, frame: Frame, world: World, barred: Barred = frozenset()) -> Choice:
        self.asked.append(barred)
        callee, arguments = self.wanted[frame.program]
        return Choice(None) if callee in barred else Choice(callee, arguments)


@pytest.fixture(scope="module")
def stacking() -> Registry:
    return load("block_stacking")


def run(registry: Registry, policy: Stubborn, change: Callable[[KinematicWorld], None] | None = None) -> Run:
    rng = np.random.default_rng(0)
    instance = draw(registry, find_task(registry, "block_stacking"), rng)
    world = KinematicWorld()
    world.reset(instance.nominal_start(rng), 0)
    if change is not None:
        change(world)
    return Interpreter(registry, policy, world).run("stack", ())


class Alternating(Stubborn):
    """Makes the first of several calls that is not barred; returns where all are."""

    def decide(self, frame: Frame, world: World, barred: Barred = frozenset()) -> Choice:
        self.asked.append(barred)
        for callee, arguments in ALTERNATIVES.get(
            frame.program, [self.wanted.get(frame.program, (None, ()))]
        ):
            if callee not in barred:
                return Choice(callee, arguments)
        return Choice(None)


ALTERNATIVES: dict[str, list[tuple[str | None, tuple[Argument, ...]]]] = {
    "pick": [("move_to", ("block_3",)), ("put_down", ())],
    "put_down": [("release", ())],
}
IN_VAIN = {
    "stack": ("pick_and_place", ("block_0", "block_1")),
    "pick_and_place": ("pick", ("block_0",)),
    "pick": ("move_to", ("block_0",)),
}


def test_a_primitive_or_program_that_changes_nothing_is_not_repeated(stacking: Registry) -> None:
    done = run(stacking, Stubborn(IN_VAIN))
    assert done.done and done.primitives <= 4, "moving there once more changes nothing, so all of it ends"


def test_a_call_that_was_not_ready_is_not_repeated(stacking: Registry) -> None:
    wanted = IN_VAIN | {"pick": ("grasp", ("block_0",))}
    assert run(stacking, Stubborn(wanted)).primitives <= 4


def test_what_fails_by_chance_may_be_tried_again(stacking: Registry) -> None:
    tries = []

    def unlucky(world: KinematicWorld) -> None:
        def grasp(target: str) -> Outcome:
            tries.append(target)
            return ACHIEVED if len(tries) > 3 else Outcome(False, Failure.GRASP_FAILED)

        world.skills["grasp"] = grasp

    run(stacking, Stubborn(IN_VAIN | {"pick": ("grasp", ("block_0",))}), unlucky)
    assert len(tries) >= 4


def test_a_program_whose_calls_are_all_refused_is_unfinished_and_not_done(stacking: Registry) -> None:
    def blocked(world: KinematicWorld) -> None:
        world.skills["move_to"] = lambda target: Outcome(False, Failure.GOAL_IN_COLLISION)

    ended = run(stacking, Alternating(IN_VAIN), blocked)
    assert not ended.done and ended.ending is Ending.UNFINISHED
    assert ended.primitives <= 2 * TRIES, "each is tried a few times, then its caller is told"


def test_a_state_that_comes_round_again_is_the_same_state(stacking: Registry) -> None:
    rng = np.random.default_rng(0)
    scene = draw(stacking, find_task(stacking, "block_stacking"), rng).nominal_start(rng)
    world = KinematicWorld()
    world.reset(scene, 0)
    here = world.truth()
    world.call("move_to", ("block_0",))
    there, call = world.truth(), ("grasp", ("block_0",))
    refusals = Refusals()
    for _ in range(TRIES):
        assert refusals.barred(call, here) is None
        refusals.add(call, here, InVain.FAILED, by_chance=True)
    assert refusals.barred(call, here) is InVain.FAILED
    assert refusals.barred(call, there) is None, "elsewhere it may be tried"


class ThereAndBack(Alternating):
    """Goes to one block and to another, and back, each time changing something."""

    def decide(self, frame: Frame, world: World, barred: Barred = frozenset()) -> Choice:
        if frame.program != "pick" or "move_to" in barred:
            return super().decide(frame, world, barred)
        seen = world.truth()
        nearer = min(("block_3", "block_4"), key=lambda name: dist(seen.positions[name], seen.gripper))
        return Choice("move_to", ("block_4" if nearer == "block_3" else "block_3",))


def test_a_cycle_of_calls_that_succeed_ends_unfinished(stacking: Registry) -> None:
    ended = run(stacking, ThereAndBack(IN_VAIN))
    assert ended.ending is Ending.UNFINISHED and ended.primitives <= 3 * ROUNDS


def test_a_program_that_calls_itself_with_nothing_changed_ends_unfinished(stacking: Registry) -> None:
    ended = run(stacking, Stubborn(IN_VAIN | {"pick": ("pick", ("block_0",))}))
    assert ended.ending is Ending.UNFINISHED and ended.primitives == 0


@pytest.mark.parametrize("wrong", [("fly", ()), ("move_to", ()), ("pick", ("block_0", "block_1"))])
def test_a_policy_that_chooses_what_is_not_declared_is_told_so(
    stacking: Registry, wrong: tuple[str, tuple[str, ...]]
) -> None:
    with pytest.raises(NtpError, match=f"the policy chose '?{wrong[0]}"):
        run(stacking, Stubborn({"stack": wrong}))


def test_a_world_that_answers_with_no_outcome_is_told_so(stacking: Registry) -> None:
    def silent(world: KinematicWorld) -> None:
        world.skills["move_to"] = lambda target: None  # type: ignore[assignment, return-value]

    with pytest.raises(NtpError, match="the world answered move_to with None; expected an Outcome"):
        run(stacking, Stubborn({"stack": ("move_to", ("block_0",))}), silent)
