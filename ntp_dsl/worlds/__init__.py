"""The worlds that ship: a kinematic one, and the planned one with an arm."""

from __future__ import annotations

from ntp_dsl.language.diagnostics import NtpError
from ntp_dsl.predicates import BUILT_IN
from ntp_dsl.registry import Registry
from ntp_dsl.world import World

WORLDS = ("kinematic", "bullet")


def make_world(name: str, registry: Registry) -> World:
    """A world that can do what a library declares. Imports what it needs and no more.

    Raises `NtpError` for a world that does not exist, and for an api or predicate that it lacks.
    """
    world = _make(name)
    lacking = sorted(registry.apis.keys() - world.apis) + sorted(
        declared.name
        for declared in registry.predicates.values()
        if declared.body is None and declared.name not in BUILT_IN
    )
    if lacking:
        raise NtpError(
            f"the {name} world has nothing for {', '.join(lacking)} of library '{registry.name}'; "
            f"it has the apis {', '.join(sorted(world.apis))} and the predicates {', '.join(BUILT_IN)}"
        )
    return world


def _make(name: str) -> World:
    if name == "kinematic":
        from ntp_dsl.worlds.kinematic import KinematicWorld

        return KinematicWorld()
    if name == "bullet":
        from ntp_dsl.worlds.bullet import BulletWorld

        return BulletWorld()
    raise NtpError(f"no world is called '{name}'; there are {', '.join(WORLDS)}")
