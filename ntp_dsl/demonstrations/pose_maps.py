"""What the columns of a table of poses are: names, units and frames, told by a TOML.

[time]
column = "t"
unit = "ms"

[frame]                              # of all positions
unit = "mm"
origin = [0.4, 0.0, 0.0]             # in the robot's frame [m]
rotation = [0.0, 0.0, 90.0]          # about the robot's x, y and z axes, in this order [deg]

[gripper]
position = ["hand_x", "hand_y", "hand_z"]
closed = "width"
below = 35.0                         # it is closed where the column is below that; without it: true or 1

[objects.block_0]
position = ["b0_x", "b0_y", "b0_z"]
orientation = ["b0_qx", "b0_qy", "b0_qz", "b0_qw"]
centre = [0.0, 0.0, -0.025]          # from the tracked point, in the object's own frame [m]
"""

from __future__ import annotations

import tomllib
from collections.abc import Iterator, Sequence
from math import isfinite
from pathlib import Path
from typing import Annotated, Any, Literal

import msgspec
from msgspec import Meta

from ntp_dsl.common.decoding import Unreadable, decoding
from ntp_dsl.language.diagnostics.diagnostics import NtpError
from ntp_dsl.semantics.geometry import Vector
from ntp_dsl.semantics.observation import SceneObject
from ntp_dsl.worlds.starts import furniture_positions

SECONDS = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9}
METRES = {"m": 1.0, "cm": 1e-2, "mm": 1e-3}
AXES = ("x", "y", "z", "w")
LARGEST = 10**6  # characters of a map

Names = tuple[str, str, str]


class Time(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """The column of the times."""

    column: str = "time"
    unit: Literal["s", "ms", "us", "ns"] = "s"


class Coordinates(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """The frame and the unit of all positions."""

    unit: Literal["m", "cm", "mm"] = "m"
    origin: Vector = (0.0, 0.0, 0.0)  # in the robot's frame [m]
    rotation: Vector = (0.0, 0.0, 0.0)  # about the robot's x, y and z axes, in this order [deg]


class Hand(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """The columns of the gripper, or of a hand."""

    position: Names = ("gripper_x", "gripper_y", "gripper_z")
    closed: str = "closed"
    below: float | None = None  # a width: the hand is closed where the column is below that
    above: float | None = None  # a force, or a degree of closing


class Tracked(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """The columns of an object."""

    position: Names
    orientation: tuple[str, str, str, str] | None = None  # quaternion x, y, z, w
    centre: Vector = (0.0, 0.0, 0.0)  # from the tracked point, in the object's own frame [m]
    deviation: Annotated[float, Meta(gt=0)] | None = None  # standard, of the position [m]


class PoseMap(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """What the columns of a table are."""

    objects: dict[str, Tracked]
    time: Time = Time()
    frame: Coordinates = Coordinates()
    gripper: Hand = Hand()
    gap: Annotated[float, Meta(ge=0)] = 0.5  # the longest without tracking that is bridged [s]


def template(objects: Sequence[SceneObject]) -> str:
    """Return a map to edit, with all objects of a scene that are not tables."""
    tables = furniture_positions(objects)
    rows = [
        "[time]",
        'column = "time"',
        'unit = "s"  # s, ms, us or ns',
        "",
        "[frame]",
        'unit = "m"  # m, cm or mm, of all positions in the table',
        "origin = [0.0, 0.0, 0.0]  # of its frame in the robot's, in metres",
        "rotation = [0.0, 0.0, 0.0]  # about the robot's x, y and z axes, in degrees",
        "",
        "[gripper]",
        'position = ["gripper_x", "gripper_y", "gripper_z"]',
        'closed = "closed"  # true or 1; of a width or a force, with a line: below = 0.03, or above = 2.0',
    ]
    for obj in objects:
        if obj.name not in tables:
            names = ", ".join(f'"{obj.name}_{axis}"' for axis in AXES[:3])
            rows += ["", f"[objects.{obj.name}]", f"position = [{names}]"]
    return "\n".join([*rows, ""])


def read_map(path: Path) -> PoseMap:
    """Read a map. Raises `NtpError`, with the place, for anything else."""
    try:
        text = path.read_text(encoding="utf-8")
    except UnicodeDecodeError as error:
        raise NtpError(f"{path}: expected TOML in UTF-8, found something else") from error
    if len(text) > LARGEST:
        raise NtpError(f"{path}: expected at most {LARGEST} characters")
    try:
        with decoding():
            table = tomllib.loads(text)
            found = msgspec.convert(table, PoseMap)
    except Unreadable as error:
        raise NtpError(f"{path}: {error}") from error
    if fault := next(_faults(table, found), ""):
        raise NtpError(f"{path}: {fault}")
    return found


def _faults(table: dict[str, Any], found: PoseMap) -> Iterator[str]:
    """Yield what a map says that cannot be."""
    for key, value in _numbers(table, ""):
        if not isfinite(value):
            yield f"expected a finite number of '{key}', found {value}"
    if found.gripper.below is not None and found.gripper.above is not None:
        yield "expected the gripper to be closed below a value, or above one, found both"
    told = [name for name, tracked in found.objects.items() if tracked.deviation is not None]
    if told and len(told) < len(found.objects):
        missing = next(name for name in found.objects if name not in told)
        yield f"expected a deviation of all objects or of none, found none of '{missing}'"
    for name, tracked in found.objects.items():
        if any(tracked.centre) and tracked.orientation is None:
            yield f"expected an orientation of '{name}', in whose own frame its centre is told"


def _numbers(value: Any, key: str) -> Iterator[tuple[str, float]]:
    """Yield all numbers in a table, with their keys."""
    if isinstance(value, float):
        yield key, value
    elif isinstance(value, dict):
        for name, inner in value.items():
            yield from _numbers(inner, f"{key}.{name}".lstrip("."))
    elif isinstance(value, list):
        for inner in value:
            yield from _numbers(inner, key)
