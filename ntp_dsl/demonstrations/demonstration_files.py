"""Demonstrations as Parquet files, one row a frame: docs/demonstrations.md has the columns.

A file made elsewhere needs only the columns; the scene describes its objects then.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
from numpy.typing import NDArray

from ntp_dsl.common.files import written_whole
from ntp_dsl.demonstrations.demonstration import UNKNOWN, Demonstration, Facts, Origin
from ntp_dsl.language.diagnostics.diagnostics import NtpError
from ntp_dsl.semantics.observation import DeclaredFact, Record, SceneObject

FORMAT = "ntp-demonstration"  # also the key of the header among the file's metadata
VERSION = 2
POSITION, ORIENTATION, DEVIATION = "position.", "orientation.", "deviation."  # before an object's name


class Header(msgspec.Struct, frozen=True, kw_only=True):
    """The header of a file."""

    format: str
    version: int
    objects: tuple[SceneObject, ...]
    origin: Origin = UNKNOWN


class _HeaderOfVersion1(msgspec.Struct, frozen=True):
    """The first version: positions were relative to the gripper, which was not stored."""

    things: tuple[SceneObject, ...]
    notes: dict[str, Any] = {}


class _Versioned(msgspec.Struct):
    version: int


def write_demonstration(demonstration: Demonstration, path: Path) -> None:
    """Write a demonstration; the file appears under its name only when it is whole."""
    import pyarrow as pa
    from pyarrow import parquet

    columns: dict[str, Any] = {
        "time": pa.array(demonstration.times),
        "closed": pa.array(demonstration.closed),
        "gripper": _fixed(demonstration.grippers, pa.float64()),
    }
    for index, name in enumerate(demonstration.names):
        columns[POSITION + name] = _fixed(demonstration.positions[:, index], pa.float64())
        if demonstration.orientations is not None:
            columns[ORIENTATION + name] = _fixed(demonstration.orientations[:, index], pa.float32())
        if demonstration.deviations is not None:
            columns[DEVIATION + name] = pa.array(demonstration.deviations[:, index])
    if demonstration.facts is not None:
        texts = [msgspec.json.encode(sorted(facts)).decode() for facts in demonstration.facts]
        columns["facts"] = pa.array(texts)
    header = Header(
        format=FORMAT, version=VERSION, objects=demonstration.objects, origin=demonstration.origin
    )
    table = pa.table(columns).replace_schema_metadata({FORMAT: msgspec.json.encode(header)})
    with written_whole(path) as partial:
        parquet.write_table(table, partial)


def read_demonstration(path: Path, scene: Sequence[SceneObject] = ()) -> Demonstration:
    """Read a demonstration.

    Args:
        scene: the objects that a file without a header may show.

    Raises `NtpError`, with what was expected and found, for anything but a whole demonstration.
    """
    table = _table(path)
    header = _header(table, path)
    if isinstance(header, _HeaderOfVersion1):
        return _checked(_version_1(table, header, path), path)
    objects = header.objects if header else _named(table, scene, path)
    try:
        found = Demonstration(
            objects,
            table["time"].to_numpy().astype(np.float32),
            table["closed"].to_numpy(zero_copy_only=False).astype(bool),
            _rows(table, "gripper", 3),
            np.stack([_rows(table, POSITION + each.name, 3) for each in objects], axis=1),
            _optional(table, ORIENTATION, objects, 4),
            _optional(table, DEVIATION, objects, 1),
            _facts(table),
            header.origin if header else UNKNOWN,
        )
    except (KeyError, TypeError, ValueError, AttributeError, msgspec.MsgspecError) as error:
        raise NtpError(f"{path}: the demonstration lacks a column or a field: {error}") from error
    return _checked(found, path)


def _table(path: Path) -> Any:
    import pyarrow as pa
    from pyarrow import parquet

    if not path.is_file():
        raise NtpError(f"{path}: no such demonstration; `ntp record` makes them")
    try:
        return parquet.read_table(path)
    except (pa.ArrowException, OSError) as error:
        raise NtpError(
            f"{path}: expected a demonstration (Parquet), found something else or a truncated file"
        ) from error


def _header(table: Any, path: Path) -> Header | _HeaderOfVersion1 | None:
    text = (table.schema.metadata or {}).get(FORMAT.encode())
    if text is None:
        return None
    try:
        version = msgspec.json.decode(text, type=_Versioned).version
        if version == 1:
            return msgspec.json.decode(text, type=_HeaderOfVersion1)
        if version == VERSION:
            return msgspec.json.decode(text, type=Header)
    except msgspec.MsgspecError as error:
        raise NtpError(f"{path}: the demonstration's header is not one: {error}") from error
    raise NtpError(f"{path}: expected version {VERSION} of the format, found {version}")


def _named(table: Any, scene: Sequence[SceneObject], path: Path) -> tuple[SceneObject, ...]:
    """Return the objects that the columns of a file without a header refer to."""
    names = [each.removeprefix(POSITION) for each in table.column_names if each.startswith(POSITION)]
    if not names:
        found = ", ".join(table.column_names[:4])
        raise NtpError(
            f"{path}: expected a demonstration with the columns time, closed, gripper and {POSITION}NAME, "
            f"found a table of {found}"
        )
    known = {each.name: each for each in scene}
    if unknown := [name for name in names if name not in known]:
        there = f"the scene has {', '.join(known)}" if known else "and the file has no header"
        raise NtpError(f"{path}: unknown objects {', '.join(unknown)}: {there}")
    return tuple(known[name] for name in names)


def _version_1(table: Any, header: _HeaderOfVersion1, path: Path) -> Demonstration:
    """Return it with the gripper at the origin in every frame: only relative positions are known."""
    try:
        goal = tuple(Record("", tuple(row.items())) for row in header.notes.get("goal", ()))
        times = table["time"].to_numpy().astype(np.float32)
        places = np.stack([_rows(table, POSITION + each.name, 3) for each in header.things], axis=1)
        closed = table["closed"].to_numpy(zero_copy_only=False).astype(bool)
    except (KeyError, TypeError, ValueError, AttributeError) as error:
        raise NtpError(f"{path}: the demonstration lacks a column or a field: {error}") from error
    origin = Origin(goal=goal)
    return Demonstration(header.things, times, closed, np.zeros((len(times), 3)), places, origin=origin)


def _checked(found: Demonstration, path: Path) -> Demonstration:
    arrays = (found.positions, found.grippers, found.orientations, found.deviations)
    if not len(found) or not all(each is None or np.isfinite(each).all() for each in arrays):
        raise NtpError(f"{path}: expected frames of finite positions, found none or NaN")
    return found


def _fixed(rows: NDArray[Any], kind: Any) -> Any:
    """Return (T, K) numbers as a column of K each."""
    import pyarrow as pa

    flat = pa.array(np.ascontiguousarray(rows).reshape(-1), type=kind)
    return pa.FixedSizeListArray.from_arrays(flat, type=pa.list_(kind, rows.shape[1]))


def _rows(table: Any, column: str, length: int) -> NDArray[np.float64]:
    """Return a column of lists as (T, length)."""
    flat = np.asarray(table[column].combine_chunks().flatten(), dtype=np.float64)
    return flat.reshape(-1, length)


def _optional(
    table: Any, prefix: str, objects: Sequence[SceneObject], length: int
) -> NDArray[np.float32] | None:
    """Return (T, N, length), or (T, N) for single numbers; None where the file has no such columns."""
    columns = [prefix + each.name for each in objects]
    if not any(each in table.column_names for each in columns):
        return None
    if length == 1:
        return np.stack([table[each].to_numpy().astype(np.float32) for each in columns], axis=1)
    return np.stack([_rows(table, each, length).astype(np.float32) for each in columns], axis=1)


def _facts(table: Any) -> tuple[Facts, ...] | None:
    if "facts" not in table.column_names:
        return None
    texts = table["facts"].to_pylist()
    return tuple(frozenset(msgspec.json.decode(each, type=list[DeclaredFact])) for each in texts)
