"""Demonstrations as Parquet files, one row a frame: docs/demonstrations.md has the columns.

A file made elsewhere needs only the columns; the scene describes its objects then, and its tables need no
column.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
from numpy.typing import NDArray

from ntp_dsl.common.decoding import Count, Unreadable, decode, decoding
from ntp_dsl.common.files import written_whole
from ntp_dsl.common.text import shortened
from ntp_dsl.demonstrations.demonstration import UNKNOWN, Demonstration, Facts, Origin
from ntp_dsl.language.diagnostics.diagnostics import NtpError
from ntp_dsl.semantics.observation import DeclaredFact, Record, SceneObject
from ntp_dsl.worlds.starts import furniture_positions

FORMAT = "ntp-demonstration"  # also the key of the header among the file's metadata
VERSION = 2
FARTHEST = 10.0  # that anything lies from the robot's base [m]
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
    version: Count


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


def read_demonstration(path: Path | str, scene: Sequence[SceneObject] = ()) -> Demonstration:
    """Read a demonstration.

    Args:
        scene: the objects that a file without a header may show, such as those of a task.

    Raises `NtpError`, with what was expected and found, for anything but a whole demonstration.
    """
    path = Path(path)
    table = _table(path)
    header = _header(table, path)
    objects = () if isinstance(header, _HeaderOfVersion1) else _objects(table, header, scene, path)
    try:
        with decoding(), np.errstate(all="ignore"):  # what overflows is refused as infinite
            if isinstance(header, _HeaderOfVersion1):
                found = _version_1(table, header)
            else:
                found = _present_version(table, objects, header.origin if header else UNKNOWN)
    except Unreadable as error:
        raise NtpError(f"{path}: the demonstration lacks a column or a field: {error}") from error
    return checked(found, path)


def _table(path: Path) -> Any:
    import pyarrow as pa
    from pyarrow import parquet

    if not path.is_file():
        raise NtpError(f"{path}: no such demonstration; `ntp record` makes them")
    try:
        with decoding():
            return parquet.read_table(path)
    except (pa.ArrowException, OSError, Unreadable) as error:
        raise NtpError(
            f"{path}: expected a demonstration (Parquet), found something else or a truncated file"
        ) from error


def _header(table: Any, path: Path) -> Header | _HeaderOfVersion1 | None:
    text = (table.schema.metadata or {}).get(FORMAT.encode())
    if text is None:
        return None
    try:
        version = decode(text, _Versioned).version
        if version == 1:
            return decode(text, _HeaderOfVersion1)
        if version == VERSION:
            return decode(text, Header)
    except Unreadable as error:
        raise NtpError(f"{path}: the demonstration's header is invalid: {error}") from error
    raise NtpError(f"{path}: expected version {VERSION} of the format, found {version}")


def _objects(
    table: Any, header: Header | None, scene: Sequence[SceneObject], path: Path
) -> tuple[SceneObject, ...]:
    """Return the objects of a file: those of its header, or those of the scene that its columns refer to."""
    if header is not None:
        return header.objects
    names = [each.removeprefix(POSITION) for each in table.column_names if each.startswith(POSITION)]
    if not names:
        found = shortened(", ".join(table.column_names[:4]))
        raise NtpError(
            f"{path}: expected a demonstration with the columns time, closed, gripper and {POSITION}NAME, "
            f"found a table of {found}"
        )
    known = {each.name: each for each in scene}
    if unknown := [name for name in names if name not in known]:
        there = f"the scene has {', '.join(known)}"
        if not known:
            there = "the file has no header; give the objects of its scene, as in scene=task.objects"
        raise NtpError(f"{path}: unknown objects {shortened(', '.join(unknown))}: {there}")
    tables = [each for each in scene if each.name not in names and each.name in furniture_positions([each])]
    return (*(known[name] for name in names), *tables)


def _present_version(table: Any, objects: Sequence[SceneObject], origin: Origin) -> Demonstration:
    return Demonstration(
        tuple(objects),
        _times(table),
        _closed(table),
        _rows(table, "gripper", 3),
        np.stack([_positions(table, each) for each in objects], axis=1),
        _optional(table, ORIENTATION, objects, 4),
        _optional(table, DEVIATION, objects, 1),
        _facts(table),
        origin,
    )


def _version_1(table: Any, header: _HeaderOfVersion1) -> Demonstration:
    """Return it with the gripper at the origin in every frame: only relative positions are known."""
    goal = tuple(Record("", tuple(row.items())) for row in header.notes.get("goal", ()))
    times = _times(table)
    places = np.stack([_rows(table, POSITION + each.name, 3) for each in header.things], axis=1)
    at_origin = np.zeros((len(times), 3))
    return Demonstration(header.things, times, _closed(table), at_origin, places, origin=Origin(goal=goal))


def _column(table: Any, name: str) -> Any:
    """Return a column. Raises `Unreadable` where there is none of that name."""
    if name not in table.column_names:
        raise Unreadable(f"there is no '{name}'")
    return table[name]


def _times(table: Any) -> NDArray[np.float32]:
    times: NDArray[np.float32] = _column(table, "time").to_numpy().astype(np.float32)
    return times


def _closed(table: Any) -> NDArray[np.bool_]:
    values = _column(table, "closed").to_numpy(zero_copy_only=False)
    closed: NDArray[np.bool_] = values.astype(bool)
    if values.dtype.kind not in "biuf" or not (closed == values).all():
        raise Unreadable("'closed' is expected to be true or false, or 1 or 0")
    return closed


def _positions(table: Any, obj: SceneObject) -> NDArray[np.float64]:
    """Return where an object was in each frame, (T, 3); a table without a column was where tables are."""
    column = POSITION + obj.name
    still = furniture_positions([obj])
    if column in table.column_names or obj.name not in still:
        return _rows(table, column, 3)
    return np.tile(np.array(still[obj.name]), (table.num_rows, 1))


def checked(found: Demonstration, path: Path) -> Demonstration:
    """Return a demonstration that is possible. Raises `NtpError` for any other."""
    if fault := _fault(found):
        raise NtpError(f"{path}: {fault}")
    return found


def _fault(found: Demonstration) -> str:
    """Return what is impossible about a demonstration, and where; empty where nothing is."""
    per_object = {
        POSITION: found.positions,
        ORIENTATION: found.orientations,
        DEVIATION: found.deviations,
    }
    columns: dict[str, NDArray[Any]] = {
        "time": found.times,
        "gripper": found.grippers,
        "closed": found.closed,
    }
    for prefix, values in per_object.items():
        if values is not None:
            columns |= {prefix + name: values[:, index] for index, name in enumerate(found.names)}
    if not len(found):
        return "expected frames, found none"
    if len({*found.names}) < len(found.names):
        return "expected objects of different names, found one name twice"
    for name, values in columns.items():
        if len(values) != len(found):
            return f"expected a value of every column in every frame, found {len(values)} of '{name}'"
        if not (finite := np.isfinite(values)).all():
            return (
                f"expected finite numbers, found {values[~finite][0]} in '{name}' at frame {_first(~finite)}"
            )
    for name in ("gripper", *(POSITION + each for each in found.names)):
        if (far := np.abs(columns[name]) > FARTHEST).any():
            distance, at = columns[name][far][0], _first(far)
            return (
                f"expected metres, within {FARTHEST:g} m of the robot's base; found {distance:g} in '{name}' "
                f"at frame {at}: are these millimetres?"
            )
    if (back := np.diff(found.times) < 0).any():
        return f"expected times [s] that do not decrease, found a step back at frame {_first(back) + 1}"
    if len(found) > 1 and found.times[-1] <= found.times[0]:
        return f"expected times [s] that increase, found {found.times[0]:g} in all frames"
    return ""


def _first(wrong: NDArray[np.bool_]) -> int:
    """Return the first frame in which anything is wrong."""
    return int(np.argwhere(wrong)[0][0])


def _fixed(rows: NDArray[Any], kind: Any) -> Any:
    """Return (T, K) numbers as a column of K each."""
    import pyarrow as pa

    flat = pa.array(np.ascontiguousarray(rows).reshape(-1), type=kind)
    return pa.FixedSizeListArray.from_arrays(flat, type=pa.list_(kind, rows.shape[1]))


def _rows(table: Any, column: str, length: int) -> NDArray[np.float64]:
    """Return a column of lists as (T, length). Raises `Unreadable` where a frame has no value."""
    values = _column(table, column)
    if values.null_count:
        missing = values.is_null().to_pylist().index(True)
        raise Unreadable(f"there is no value in '{column}' at frame {missing}")
    flat = np.asarray(values.combine_chunks().flatten(), dtype=np.float64)
    return flat.reshape(-1, length)


def _optional(
    table: Any, prefix: str, objects: Sequence[SceneObject], length: int
) -> NDArray[np.float32] | None:
    """Return (T, N, length), or (T, N) for single numbers; None where the file has no such columns."""
    columns = [prefix + each.name for each in objects]
    if not any(each in table.column_names for each in columns):
        return None
    if length == 1:
        return np.stack([_column(table, each).to_numpy().astype(np.float32) for each in columns], axis=1)
    return np.stack([_rows(table, each, length).astype(np.float32) for each in columns], axis=1)


def _facts(table: Any) -> tuple[Facts, ...] | None:
    if "facts" not in table.column_names:
        return None
    texts = table["facts"].to_pylist()
    return tuple(frozenset(decode(each, list[DeclaredFact])) for each in texts)
