"""The stack machine itself: what it lets a policy do again, and what it does not."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from ntp_dsl.execution.interpreter import Interpreter, Run
from ntp_dsl.language.loader import load
from ntp_dsl.language.registry import Registry
from ntp_dsl.policies.protocol import Barred, Choice, Frame
from ntp_dsl.semantics.observation import Argument
from ntp_dsl.tasks.instances import draw, find_task
from ntp_dsl.worlds.kinematic import KinematicWorld
from ntp_dsl.worlds.protocol import ACHIEVED, Failure, Outcome, World


class Stubborn:
    """A policy that wants the same call for ever, unless it is told that it may not have it."""

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
    world.reset(instance.scattered(rng), 0)
    if change is not None:
        change(world)
    return Interpreter(registry, policy, world).run("stack", ())


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
