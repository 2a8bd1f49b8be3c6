"""The worlds that ship: a kinematic one, and the planned one with an arm."""

from __future__ import annotations

from ntp_dsl.language.diagnostics import NtpError
from ntp_dsl.world import World

WORLDS = ("kinematic", "bullet")


def make_world(name: str) -> World:
    """Imports what it needs and no more. Raises `NtpError` for a world that does not exist."""
    if name == "kinematic":
        from ntp_dsl.worlds.kinematic import KinematicWorld

        return KinematicWorld()
    if name == "bullet":
        from ntp_dsl.worlds.bullet import BulletWorld

        return BulletWorld()
    raise NtpError(f"no world is called '{name}'; there are {', '.join(WORLDS)}")
