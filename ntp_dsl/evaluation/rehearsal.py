"""A task that was told, done once without physics before the robot does it: can all of it come about?"""

from __future__ import annotations

from collections.abc import Callable

from ntp_dsl.execution.interpreter import Interpreter, Limits
from ntp_dsl.language.registry import Registry
from ntp_dsl.policies.expert import Expert
from ntp_dsl.policies.scripted import ScriptedPolicy
from ntp_dsl.semantics.observation import Observation
from ntp_dsl.semantics.shortfalls import why_not
from ntp_dsl.semantics.state import State
from ntp_dsl.tasks.instances import Instance, enough_primitives
from ntp_dsl.worlds.catalogue import make_world
from ntp_dsl.worlds.protocol import Scene, World


def rehearsed(
    registry: Registry,
    instance: Instance,
    scene: Scene,
    on_frame: Callable[[Observation], None] | None = None,
) -> World:
    """Return a world without physics in which the scripted expert has done a task.

    Args:
        on_frame: is told every frame.
    """
    world = make_world("kinematic", registry, exact=True)
    world.reset(scene, 0)
    world.on_frame = on_frame
    limits = Limits(primitives=enough_primitives(instance))
    Interpreter(registry, ScriptedPolicy(Expert(registry)), world, limits=limits).run(
        instance.program, instance.arguments
    )
    return world


def shortfall(registry: Registry, instance: Instance, scene: Scene) -> str:
    """Return what does not come about when the scripted expert does the task, or nothing."""
    end = rehearsed(registry, instance, scene).truth()
    state = State(registry, end)
    lacking = (fact for fact in instance.literals(registry, end) if not state.holds(fact))
    return next((why_not(fact, state) for fact in lacking), "")
