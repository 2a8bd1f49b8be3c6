"""A task as a demonstration shows it: over the same objects, with the goal that the demonstration states."""

from __future__ import annotations

from ntp_dsl.demonstrations.demonstration import Demonstration, check_objects
from ntp_dsl.language.diagnostics.diagnostics import NtpError
from ntp_dsl.language.registry import Registry
from ntp_dsl.semantics.observation import Record
from ntp_dsl.tasks.goal_samplers import Goal
from ntp_dsl.tasks.instances import Instance


def as_demonstrated(registry: Registry, instance: Instance, demonstration: Demonstration) -> Instance:
    """Return an instance with the demonstration's goal, or without any where it states none.

    The goal is for the judge alone: the policy never sees it. Raises `NtpError` for a demonstration of other
    objects, and for a goal that is not one of this task.
    """
    check_objects(demonstration, instance.objects)
    return instance.with_goal(_goal(registry, demonstration, instance))


def _goal(registry: Registry, demonstration: Demonstration, instance: Instance) -> Goal:
    """Return the goal that a demonstration states, by which success is judged; empty if it states none.

    The policy never sees it.
    """
    rows = demonstration.origin.goal
    if not rows:
        return ()
    if not instance.goal:
        raise NtpError(
            f"the demonstration states a goal, and task '{instance.name}' has none: is it of another task?"
        )
    pattern = instance.goal[0]
    try:
        goal = tuple(
            Record(pattern.type, tuple((name, type(value)(row[name])) for name, value in pattern.fields))
            for row in rows
        )
    except (KeyError, TypeError, ValueError) as error:
        fields = ", ".join(name for name, _ in pattern.fields)
        raise NtpError(
            f"the demonstration's goal does not fit this task, whose goal elements have {fields}"
        ) from error
    known = {*demonstration.names, *(name for enum in registry.enums.values() for name in enum)}
    missing = {value for row in goal for _, value in row.fields if isinstance(value, str)} - known
    if missing:
        raise NtpError(f"the demonstration's goal names {', '.join(sorted(missing))}, which it lacks")
    return goal
