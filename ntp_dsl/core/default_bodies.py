"""Bodies for programs in Python: their calls in order, arguments by name and type, proven by simulation.

A program that its declaration leaves to a function has no row. Often a plain body reaches the goal as well;
then that is what the core dispatches over. Else the function itself decides, and the trace says so.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace

import numpy as np

from ntp_dsl.execution.interpreter import Interpreter, Limits
from ntp_dsl.language.diagnostics.diagnostics import NtpError
from ntp_dsl.language.registry import Callable, Parameter, Program, Registry
from ntp_dsl.language.syntax import nodes
from ntp_dsl.policies.expert import Expert
from ntp_dsl.policies.scripted import ScriptedPolicy
from ntp_dsl.semantics.state import State
from ntp_dsl.tasks.instances import Instance, draw, enough_primitives
from ntp_dsl.worlds.catalogue import make_world
from ntp_dsl.worlds.protocol import World

NOMINAL, PERTURBED = 4, 4  # starts of each task that a body must reach the goal from
ELEMENT = "each"

Terms = Mapping[str, tuple[nodes.Expression, Parameter]]  # by name: what an argument may be


def with_default_bodies(registry: Registry) -> Registry:
    """Return the registry in which programs in Python have bodies, where those reach the tasks' goals."""
    for program in registry.programs.values():
        if not program.in_python:
            continue
        body = tuple(_statements(registry, program))
        if body:
            changed = replace(program, body=body, in_python=False)
            tried = replace(registry, programs={**registry.programs, program.name: changed})
            if _reaches_goals(tried, program.name):
                registry = tried
    return registry


def _statements(registry: Registry, program: Program) -> Iterator[nodes.Statement]:
    own: Terms = {each.name: (nodes.Name(each.name), each) for each in program.parameters}
    lists = [each for each in program.parameters if each.is_list]
    for name in program.callees:
        callee = registry[name]
        if (terms := _bound(registry, callee, own)) is not None:
            yield nodes.Call(name, terms, span=program.span)
            continue
        for parameter in lists:
            fields: Terms = {
                each.name: (nodes.Field(nodes.Name(ELEMENT), each.name), each)
                for each in registry.records.get(parameter.type, ())
            }
            element = {ELEMENT: (nodes.Name(ELEMENT), replace(parameter, is_list=False))}
            terms = _bound(registry, callee, {**own, **element, **fields})
            if terms is not None:
                generator = nodes.Generator(ELEMENT, nodes.Name(parameter.name))
                yield nodes.For(generator, nodes.Call(name, terms, span=program.span), span=program.span)
                break


def _bound(registry: Registry, callee: Callable, terms: Terms) -> tuple[nodes.Expression, ...] | None:
    """Return an argument for each parameter: of its name, or else the only one of its type; None without."""
    found = []
    for parameter in callee.parameters:
        fitting = {
            name: term
            for name, (term, given) in terms.items()
            if given.is_list == parameter.is_list and registry.takes(parameter, given)
        }
        if parameter.name in fitting:
            found.append(fitting[parameter.name])
        elif len(fitting) == 1:
            found += fitting.values()
        else:
            return None
    return tuple(found)


def _reaches_goals(registry: Registry, program: str) -> bool:
    """Return whether each task that needs a program reaches its goal from all starts, with true facts."""
    world = make_world("kinematic", registry, exact=True)
    expert = Expert(registry)
    tasks = [
        task for task in registry.tasks.values() if task.run and program in _below(registry, task.run.callee)
    ]
    tried = 0
    for task in tasks:
        for number in range(NOMINAL + PERTURBED):
            rng = np.random.default_rng(number)
            try:
                instance = draw(registry, task, rng)
                start = instance.nominal_start if number < NOMINAL else instance.perturbed_start
                world.reset(start(rng), number)
            except NtpError:  # there was no room this time
                continue
            if not _reaches_goal(expert, world, instance):
                return False
            tried += 1
    return tried > 0


def _reaches_goal(expert: Expert, world: World, instance: Instance) -> bool:
    limits = Limits(primitives=enough_primitives(instance), retries=1)
    interpreter = Interpreter(expert.registry, ScriptedPolicy(expert), world, limits=limits)
    try:
        run = interpreter.run(instance.program, instance.arguments)
    except NtpError:  # such as a number out of an api's range
        return False
    now = world.truth()
    state = State(expert.registry, now)
    return run.done and all(map(state.holds, instance.literals(expert.registry, now)))


def _below(registry: Registry, program: str) -> set[str]:
    found: set[str] = set()
    waiting = [program]
    while waiting:
        name = waiting.pop()
        if name not in found and name in registry.programs:
            found.add(name)
            waiting += registry.programs[name].callees
    return found
