"""A task that was told, done once without physics before the robot does it: can all of it come about?"""

from __future__ import annotations

from ntp_dsl.execution.interpreter import Interpreter, Limits
from ntp_dsl.language.registry import Registry
from ntp_dsl.policies.expert import Expert
from ntp_dsl.policies.scripted import ScriptedPolicy
from ntp_dsl.semantics.shortfalls import why_not
from ntp_dsl.semantics.state import State
from ntp_dsl.tasks.instances import Instance, enough_primitives
from ntp_dsl.worlds.catalogue import make_world
from ntp_dsl.worlds.protocol import Scene


def shortfall(registry: Registry, instance: Instance, scene: Scene) -> str:
    """Return what does not come about when the scripted expert does the task, or nothing."""
    world = make_world("kinematic", registry, exact=True)
    world.reset(scene, 0)
    limits = Limits(primitives=enough_primitives(instance))
    Interpreter(registry, ScriptedPolicy(Expert(registry)), world, limits=limits).run(
        instance.program, instance.arguments
    )
    end = world.truth()
    state = State(registry, end)
    lacking = (fact for fact in instance.literals(registry, end) if not state.holds(fact))
    return next((why_not(fact, state) for fact in lacking), "")
