"""Demonstrations from tables of poses that were recorded elsewhere, in CSV or Parquet."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ntp_dsl.common.text import printable, shortened
from ntp_dsl.demonstrations.demonstration import Demonstration
from ntp_dsl.demonstrations.demonstration_files import checked
from ntp_dsl.demonstrations.pose_maps import METRES, SECONDS, PoseMap, Tracked
from ntp_dsl.language.diagnostics.diagnostics import NtpError
from ntp_dsl.semantics.geometry import Vector
from ntp_dsl.semantics.observation import SceneObject
from ntp_dsl.worlds.starts import furniture_positions

SLOW = 0.5  # between two rows, that is always accepted [s]
UNTURNED = (0.0, 0.0, 0.0, 1.0)

Columns = NDArray[np.float64]  # (T, K)


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


def imported(path: Path, told: PoseMap, objects: Sequence[SceneObject]) -> Demonstration:
    """Return the demonstration that a table holds.

    Args:
        told: what the columns are.
        objects: of the scene; each of them, but tables, must be in the map.

    Raises `NtpError` for missing objects and columns, what is no number, and gaps that are too long.
    """
    tables = furniture_positions(objects)
    _check_names(path, told, objects, tables)
    table = read_table(path)
    times = _times(path, table, told)
    if len(times) > 1 and (longest := float(np.diff(times).max())) > max(told.gap, SLOW):
        begin = float(times[int(np.argmax(np.diff(times)))])
        raise NtpError(
            f"{path}: expected rows all along, found none for {longest:.2f} s from {begin:.2f} s on; if "
            f"nothing happened meanwhile, the map may say `gap = {np.ceil(longest):g}`"
        )
    reader = _Reader(path, table, times, told)
    shown = [obj for obj in objects if obj.name in told.objects or obj.name in tables]
    turns = {name: reader.turns(tracked) for name, tracked in told.objects.items()}
    positions = [
        reader.centres(told.objects[obj.name], turns[obj.name])
        if obj.name in told.objects
        else np.tile(tables[obj.name], (len(times), 1))
        for obj in shown
    ]
    unturned = np.tile(UNTURNED, (len(times), 1))
    orientations = None
    if any(turn is not None for turn in turns.values()):
        each = [turn if (turn := turns.get(obj.name)) is not None else unturned for obj in shown]
        orientations = np.stack(each, axis=1).astype(np.float32)
    found = Demonstration(
        tuple(shown),
        times.astype(np.float32),
        reader.closed(),
        reader.positions(told.gripper.position),
        np.stack(positions, axis=1),
        orientations,
        _deviations(told, shown, len(times)),
    )
    return checked(found, path)


def _check_names(
    path: Path, told: PoseMap, objects: Sequence[SceneObject], tables: dict[str, Vector]
) -> None:
    names = {obj.name for obj in objects}
    if unknown := sorted(told.objects.keys() - names):
        raise NtpError(
            f"the map has {shortened(', '.join(unknown))}; the scene has {', '.join(sorted(names))}"
        )
    if missing := sorted(names - told.objects.keys() - tables.keys()):
        raise NtpError(
            f"the map lacks {shortened(', '.join(missing))}: say in which columns of {path} they are"
        )


class _Reader:
    """Reads columns of one table, in the robot's frame."""

    def __init__(self, path: Path, table: Any, times: Columns, told: PoseMap) -> None:
        from scipy.spatial.transform import Rotation

        self._path, self._table, self._times, self._told = path, table, times, told
        self._turn = Rotation.from_euler("xyz", told.frame.rotation, degrees=True)

    def positions(self, names: Sequence[str]) -> Columns:
        """Return (T, 3) positions in the robot's frame [m]."""
        found = self._bridged(names) * METRES[self._told.frame.unit]
        return np.asarray(self._turn.apply(found)) + self._told.frame.origin

    def turns(self, tracked: Tracked) -> Columns | None:
        """Return (T, 4) quaternions in the robot's frame, or None where they are unknown."""
        from scipy.spatial.transform import Rotation

        if tracked.orientation is None:
            return None
        found = self._known(tracked.orientation)
        rows = np.flatnonzero(np.isfinite(found).all(axis=1))
        turned = np.sum(found[rows[1:]] * found[rows[:-1]], axis=1) < 0  # q and -q are the same turn
        found[rows[1:]] *= np.where(np.cumsum(turned) % 2, -1.0, 1.0)[:, None]
        found = self._with_bridges(found, tracked.orientation)
        lengths = np.linalg.norm(found, axis=1)
        if (wrong := ~((lengths > 0.5) & (lengths < 2.0))).any():
            row = int(np.argmax(wrong))
            raise NtpError(
                f"{self._path}: expected quaternions of length one in {', '.join(tracked.orientation)}, "
                f"found one of length {lengths[row]:g} in row {row + 1}"
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
        hand = self._told.gripper
        values = self._known([hand.closed])
        there = np.isfinite(values[:, 0])
        self._check_gaps(there, hand.closed)
        latest = np.maximum.accumulate(np.where(there, np.arange(len(there)), 0))
        values = values[np.where(there[latest], latest, np.argmax(there)), 0]  # it stays as it was
        if hand.below is not None:
            return np.asarray(values < hand.below)
        if hand.above is not None:
            return np.asarray(values > hand.above)
        if len(others := values[~np.isin(values, (0, 1))]):
            raise NtpError(
                f"{self._path}: expected true and false, or 1 and 0, in '{hand.closed}', found "
                f"{others[0]:g}: of a width or a force, the map says `below` or `above`"
            )
        return np.asarray(values.astype(bool))

    def _known(self, names: Sequence[str]) -> Columns:
        return _numbers(self._path, self._table, names)

    def _bridged(self, names: Sequence[str]) -> Columns:
        """Return columns in which what was not tracked is bridged in a straight line."""
        return self._with_bridges(self._known(names), names)

    def _with_bridges(self, found: Columns, names: Sequence[str]) -> Columns:
        for column, name in zip(found.T, names, strict=True):
            there = np.isfinite(column)
            self._check_gaps(there, name)
            column[~there] = np.interp(self._times[~there], self._times[there], column[there])
        return found

    def _check_gaps(self, there: NDArray[np.bool_], name: str) -> None:
        """Raise `NtpError` where a column is empty for too long, or all along."""
        if not there.any():
            raise NtpError(f"{self._path}: '{name}' has no number in any row")
        ends = [0, *np.flatnonzero(there), len(there) - 1]
        gaps = [
            float(self._times[after] - self._times[before])
            for before, after in pairwise(ends)
            if not there[before : after + 1].all()
        ]
        longest = max(gaps, default=0.0)
        if longest > self._told.gap:
            raise NtpError(
                f"{self._path}: '{name}' is empty for {longest:.2f} s, and gaps of at most "
                f"{self._told.gap:g} s are bridged; the map may say `gap = {np.ceil(longest):g}`"
            )


def _times(path: Path, table: Any, told: PoseMap) -> NDArray[np.float64]:
    """Return the times from the first row on [s]."""
    import pyarrow as pa

    name, unit = told.time.column, SECONDS[told.time.unit]
    _check_columns(path, table, [name])
    column = table[name]
    if len(column) and column.null_count == 0 and pa.types.is_integer(column.type):
        stamps = column.to_numpy().astype(np.int64)  # nanoseconds since 1970 are too long for a float
        return np.asarray((stamps - stamps[0]).astype(np.float64) * unit)
    times = _numbers(path, table, [name])[:, 0] * unit
    if not len(times):
        raise NtpError(f"{path}: expected a row a frame, found none")
    if (lost := ~np.isfinite(times)).any():
        row = int(np.argmax(lost)) + 1
        raise NtpError(f"{path}: expected a time in every row, found none in row {row} of '{name}'")
    return times - times[:1]


def _check_columns(path: Path, table: Any, names: Sequence[str]) -> None:
    there = table.column_names
    if missing := [name for name in names if name not in there]:
        raise NtpError(
            f"{path}: no column is called '{missing[0]}'; there are {shortened(', '.join(map(str, there)))}"
        )


def _numbers(path: Path, table: Any, names: Sequence[str]) -> Columns:
    """Return columns as (T, K) numbers; NaN where they are empty."""
    _check_columns(path, table, names)
    columns = []
    for name in names:
        try:
            columns.append(_floats(table[name]))
        except (TypeError, ValueError) as error:
            raise NtpError(f"{path}: expected numbers in '{name}', found {table[name].type}") from error
    return np.stack(columns, axis=1)


def _floats(column: Any) -> NDArray[np.float64]:
    import pyarrow as pa

    kind = column.type
    if pa.types.is_boolean(kind):
        column = column.cast(pa.int8())
    try:
        numbers = column.cast(pa.float64(), safe=not pa.types.is_integer(kind))
    except pa.ArrowException as error:
        raise ValueError from error
    return np.array(numbers.to_numpy(zero_copy_only=False), dtype=np.float64)


def _deviations(told: PoseMap, shown: Sequence[SceneObject], count: int) -> NDArray[np.float32] | None:
    known = [told.objects[obj.name].deviation if obj.name in told.objects else None for obj in shown]
    if all(each is None for each in known):
        return None
    exact = 0.0  # of tables, which have no columns
    return np.tile([each or exact for each in known], (count, 1)).astype(np.float32)
