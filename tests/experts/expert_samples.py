"""Experts, goals and states for the tests: anything that an arm over a table may find itself in."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from ntp_dsl.execution.interpreter import Interpreter, Limits, Run
from ntp_dsl.language.registry import Registry
from ntp_dsl.policies.expert import Expert, ExpertContext, NextCall, call, first
from ntp_dsl.policies.scripted import ScriptedPolicy
from ntp_dsl.semantics.observation import Record
from ntp_dsl.semantics.state import State
from ntp_dsl.tasks.instances import Instance, draw, find_task
from ntp_dsl.worlds.kinematic import KinematicWorld
from ntp_dsl.worlds.perturbed_starts import perturbed_start
from ntp_dsl.worlds.protocol import Disturbances

PRIMITIVES = 1000  # some forty are needed; beside a leaning tower a placement fails until luck helps


def stack_in_python(view: ExpertContext, goal: Iterable[Record]) -> list[NextCall]:
    """Do in Python what the body of `stack` declares."""
    return first(
        call("pick_and_place", p["item"], p["support"]) for p in goal if not view.on(p["item"], p["support"])
    )


def pick_and_place_in_python(view: ExpertContext, item: str, support: str) -> NextCall:
    if not view.clear(support):
        return call("clear", support)
    return call("place", item, support) if view.holding(item) else call("pick", item)


def experts(registry: Registry) -> dict[str, Expert]:
    functions = {"stack": stack_in_python, "pick_and_place": pick_and_place_in_python}
    return {"declared": Expert(registry), "in Python": Expert(registry, functions)}


def drawn(registry: Registry, seed: int, task: str = "") -> tuple[Instance, KinematicWorld]:
    """Return a goal, and a world in a perturbed start."""
    rng = np.random.default_rng(seed)
    name = task or ("block_stacking", "tall_towers")[seed % 2]
    instance = draw(registry, find_task(registry, name), rng)
    world = KinematicWorld()
    world.reset(perturbed_start(instance.objects, rng), seed)
    return instance, world


def run_from_anywhere(
    expert: Expert, seed: int, disturbances: Disturbances, primitives: int = PRIMITIVES
) -> tuple[Run, bool]:
    """Return a run from a perturbed start, and whether the goal holds in truth at its end."""
    rng = np.random.default_rng(seed)
    instance, world = drawn(expert.registry, seed)
    world.reset(perturbed_start(instance.objects, rng), seed, disturbances)
    limits = Limits(primitives=primitives)
    interpreter = Interpreter(expert.registry, ScriptedPolicy(expert), world, limits=limits)
    run = interpreter.run(instance.program, instance.arguments)
    state = State(expert.registry, world.truth())
    return run, all(state.holds(x) for x in instance.literals(expert.registry, world.truth()))
