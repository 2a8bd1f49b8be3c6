"""Demonstrations from tables of poses, in CSV or Parquet, and a map in TOML that says what is what.

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
from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from typing import Any, Literal

import msgspec
import numpy as np
from numpy.typing import NDArray

from ntp_dsl.common.decoding import Unreadable, decoding
from ntp_dsl.common.text import printable, shortened
from ntp_dsl.demonstrations.demonstration import Demonstration
from ntp_dsl.demonstrations.demonstration_files import checked
from ntp_dsl.language.diagnostics.diagnostics import NtpError
from ntp_dsl.semantics.geometry import Vector
from ntp_dsl.semantics.observation import SceneObject
from ntp_dsl.worlds.starts import furniture_positions

SECONDS = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9}
METRES = {"m": 1.0, "cm": 1e-2, "mm": 1e-3}
AXES = ("x", "y", "z", "w")
LARGEST = 10**6  # characters of a map

Columns = NDArray[np.float64]  # (T, K)
Names = tuple[str, str, str]


class Time(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """The column of the times."""

    column: str = "time"
    unit: Literal["s", "ms", "us", "ns"] = "s"


class Frame(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
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
    deviation: float | None = None  # standard, of the position [m]


class TableMap(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """What the columns of a table are."""

    objects: dict[str, Tracked]
    time: Time = Time()
    frame: Frame = Frame()
    gripper: Hand = Hand()
    gap: float = 0.5  # the longest, in which nothing was tracked, that is bridged in a straight line [s]


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


def read_map(path: Path) -> TableMap:
    """Read a map. Raises `NtpError`, with the place, for anything else."""
    try:
        text = path.read_text(encoding="utf-8")
    except UnicodeDecodeError as error:
        raise NtpError(f"{path}: expected TOML in UTF-8, found something else") from error
    if len(text) > LARGEST:
        raise NtpError(f"{path}: expected at most {LARGEST} characters")
    try:
        with decoding():
            return msgspec.convert(tomllib.loads(text), TableMap)
    except Unreadable as error:
        raise NtpError(f"{path}: {error}") from error


def read_table(path: Path) -> Any:
    """Read a CSV or Parquet file, by its ending, as a table. Raises `NtpError` for anything else."""
    import pyarrow as pa
    from pyarrow import csv, parquet

    if not path.is_file():
        raise NtpError(f"{path}: no such file")
    if path.suffix.lower() not in (".csv", ".parquet"):
        raise NtpError(f"{path}: expected a file that ends in .csv or .parquet")
    is_csv = path.suffix.lower() == ".csv"
    try:
        table = csv.read_csv(path) if is_csv else parquet.read_table(path)
        names = Counter(table.column_names)
    except (pa.ArrowException, OSError, ValueError) as error:
        kind = "CSV" if is_csv else "Parquet"
        raise NtpError(f"{path}: expected {kind}: {shortened(error)}") from error
    if twice := [name for name, count in names.items() if count > 1]:
        raise NtpError(
            f"{path}: expected columns of different names, found two called '{printable(twice[0])}'"
        )
    return table


def imported(path: Path, map: TableMap, objects: Sequence[SceneObject]) -> Demonstration:
    """Return the demonstration that a table holds.

    Args:
        objects: of the scene; each of them, but tables, must be in the map.

    Raises `NtpError` for missing objects and columns, what is no number, and gaps that are too long.
    """
    tables = furniture_positions(objects)
    _check_names(path, map, objects, tables)
    table = read_table(path)
    times = _numbers(path, table, [map.time.column])[:, 0] * SECONDS[map.time.unit]
    if (lost := ~np.isfinite(times)).any():
        row = int(np.argmax(lost)) + 1
        raise NtpError(
            f"{path}: expected a time in every row, found none in row {row} of '{map.time.column}'"
        )
    reader = _Reader(path, table, times, map)
    shown = [obj for obj in objects if obj.name in map.objects or obj.name in tables]
    turns = {name: reader.turns(tracked) for name, tracked in map.objects.items()}
    positions = [
        reader.centres(map.objects[obj.name], turns[obj.name])
        if obj.name in map.objects
        else np.tile(tables[obj.name], (len(times), 1))
        for obj in shown
    ]
    still = np.tile((0.0, 0.0, 0.0, 1.0), (len(times), 1))
    known = any(turn is not None for turn in turns.values())
    found = Demonstration(
        tuple(shown),
        (times - times[:1]).astype(np.float32),
        reader.closed(),
        reader.positions(map.gripper.position),
        np.stack(positions, axis=1),
        _stacked([_or(turns.get(obj.name), still) for obj in shown]) if known else None,
        _deviations(map, shown, len(times)),
    )
    return checked(found, path)


def _check_names(
    path: Path, map: TableMap, objects: Sequence[SceneObject], tables: dict[str, Vector]
) -> None:
    names = {obj.name for obj in objects}
    if unknown := sorted(map.objects.keys() - names):
        raise NtpError(
            f"the map has {shortened(', '.join(unknown))}; the scene has {', '.join(sorted(names))}"
        )
    if missing := sorted(names - map.objects.keys() - tables.keys()):
        raise NtpError(
            f"the map lacks {shortened(', '.join(missing))}: say in which columns of {path} they are"
        )


class _Reader:
    """Reads columns of one table, in the robot's frame."""

    def __init__(self, path: Path, table: Any, times: Columns, map: TableMap) -> None:
        from scipy.spatial.transform import Rotation

        self._path, self._table, self._times, self._map = path, table, times, map
        self._turn = Rotation.from_euler("xyz", map.frame.rotation, degrees=True)

    def positions(self, names: Sequence[str]) -> Columns:
        """Return (T, 3) positions in the robot's frame [m]."""
        found = self._bridged(names) * METRES[self._map.frame.unit]
        return np.asarray(self._turn.apply(found)) + self._map.frame.origin

    def turns(self, tracked: Tracked) -> Columns | None:
        """Return (T, 4) quaternions in the robot's frame, or None where they are unknown."""
        from scipy.spatial.transform import Rotation

        if tracked.orientation is None:
            return None
        found = self._bridged(tracked.orientation)
        if (short := np.linalg.norm(found, axis=1) < 1e-6).any():
            raise NtpError(
                f"{self._path}: expected quaternions in {', '.join(tracked.orientation)}, found zeros in row "
                f"{int(np.argmax(short)) + 1}"
            )
        return np.asarray((self._turn * Rotation.from_quat(found)).as_quat())

    def centres(self, tracked: Tracked, turns: Columns | None) -> Columns:
        """Return (T, 3) positions of an object's centre in the robot's frame [m]."""
        from scipy.spatial.transform import Rotation

        found = self.positions(tracked.position)
        if turns is None:
            return np.asarray(found + tracked.centre)
        return np.asarray(found + Rotation.from_quat(turns).apply(tracked.centre))

    def closed(self) -> NDArray[np.bool_]:
        hand = self._map.gripper
        if hand.below is not None and hand.above is not None:
            raise NtpError("the map's gripper is closed below a value, or above one: choose")
        values = self._bridged([hand.closed])[:, 0]
        if hand.below is not None:
            return np.asarray(values < hand.below)
        if hand.above is not None:
            return np.asarray(values > hand.above)
        if len(others := values[~np.isin(values, (0, 1))]):
            raise NtpError(
                f"{self._path}: expected true and false, or 1 and 0, in '{hand.closed}', found "
                f"{others[0]:g}: of a width or a force, the map says `below` or `above`"
            )
        return values.astype(bool)

    def _bridged(self, names: Sequence[str]) -> Columns:
        """Return columns in which what was not tracked is bridged in a straight line."""
        found = _numbers(self._path, self._table, names)
        for column, name in zip(found.T, names, strict=True):
            there = np.isfinite(column)
            if not there.any():
                raise NtpError(f"{self._path}: '{name}' has no number in any row")
            if there.all():
                continue
            known = self._times[there]
            gap = float(np.diff(known).max(initial=0.0))
            ends = max(known[0] - self._times[0], self._times[-1] - known[-1])
            if max(gap, ends) > self._map.gap:
                raise NtpError(
                    f"{self._path}: '{name}' is empty for {max(gap, ends):.2f} s, and gaps of at most "
                    f"{self._map.gap:g} s are bridged; the map may say `gap = {np.ceil(max(gap, ends)):g}`"
                )
            column[~there] = np.interp(self._times[~there], known, column[there])
        return found


def _numbers(path: Path, table: Any, names: Sequence[str]) -> Columns:
    """Return columns as (T, K) numbers; NaN where they are empty."""
    there = table.column_names
    if missing := [name for name in names if name not in there]:
        raise NtpError(
            f"{path}: no column is called '{missing[0]}'; there are {shortened(', '.join(map(str, there)))}"
        )
    columns = []
    for name in names:
        try:
            columns.append(_floats(table[name]))
        except (TypeError, ValueError) as error:
            raise NtpError(f"{path}: expected numbers in '{name}', found {table[name].type}") from error
    return np.stack(columns, axis=1)


def _floats(column: Any) -> NDArray[np.float64]:
    import pyarrow as pa

    try:
        numbers = column.cast(pa.float64())
    except pa.ArrowException as error:
        if not pa.types.is_boolean(column.type):
            raise ValueError from error
        numbers = column.cast(pa.int8()).cast(pa.float64())
    return np.array(numbers.to_numpy(zero_copy_only=False), dtype=np.float64)


def _or(values: Columns | None, other: Columns) -> Columns:
    return other if values is None else values


def _stacked(values: Sequence[Columns]) -> NDArray[np.float32]:
    return np.stack(values, axis=1).astype(np.float32)


def _deviations(map: TableMap, shown: Sequence[SceneObject], count: int) -> NDArray[np.float32] | None:
    told = [map.objects[obj.name].deviation if obj.name in map.objects else None for obj in shown]
    if all(each is None for each in told):
        return None
    return np.tile([each or 0.0 for each in told], (count, 1)).astype(np.float32)
