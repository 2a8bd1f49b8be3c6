"""A task specification Ψ: a time series that shows the procedure and the final objective."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from ntp_dsl.common.files import written_whole
from ntp_dsl.language.diagnostics.diagnostics import NtpError
from ntp_dsl.semantics.observation import Observation, Thing
from ntp_dsl.worlds.protocol import World

FORMAT = "ntp-demonstration"
VERSION = 1
Scope = tuple[int, int]  # frames [begin, end)


class Specification(Protocol):
    """Whatever a demonstration is made of: trajectories, video frames, a list of sentences."""

    @property
    def modality(self) -> str: ...

    def __len__(self) -> int:
        """How many steps it has; scopes are intervals of them."""


@dataclass(frozen=True, eq=False)
class Demonstration:
    """Object trajectories relative to the gripper, and the gripper's state: T frames of N things.

    Two demonstrations are the same only if they are one.
    """

    things: tuple[Thing, ...]
    positions: NDArray[np.float32]  # (T, N, 3): thing's centre minus the gripper's point [m]
    closed: NDArray[np.bool_]  # (T,)
    times: NDArray[np.float32]  # (T,) [s]
    notes: Mapping[str, Any] = field(default_factory=dict)  # where it comes from

    modality = "trajectory"

    def __len__(self) -> int:
        return len(self.times)

    @property
    def names(self) -> tuple[str, ...]:
        return tuple(thing.name for thing in self.things)


class Recorder:
    """Collects frames of a world into a demonstration; attach it as the world's `on_frame`."""

    def __init__(self, world: World, also: Callable[[Observation], None] | None = None) -> None:
        self._world, self._also = world, also
        self._frames: list[tuple[float, Observation]] = []
        world.on_frame = self.take

    def take(self, observation: Observation) -> None:
        self._frames.append((self._world.time, observation))
        if self._also is not None:
            self._also(observation)

    def __len__(self) -> int:
        return len(self._frames)

    def demonstration(self, notes: Mapping[str, Any] | None = None) -> Demonstration:
        things = self._frames[0][1].things
        positions = [
            [o.positions[thing.name] for thing in things] for _, o in self._frames
        ]  # a lost thing cannot be shown, so a demonstration has all
        grippers = np.array([o.gripper for _, o in self._frames])
        return Demonstration(
            things,
            (np.array(positions) - grippers[:, None]).astype(np.float32),
            np.array([o.closed for _, o in self._frames]),
            np.array([time for time, _ in self._frames], dtype=np.float32),
            notes or {},
        )


def write_demonstration(demonstration: Demonstration, path: Path) -> None:
    """As Parquet, one row a frame: `time`, `closed`, and a column of three numbers per thing."""
    import pyarrow as pa
    from pyarrow import parquet

    vector = pa.list_(pa.float32(), 3)
    columns: dict[str, Any] = {
        "time": pa.array(demonstration.times),
        "closed": pa.array(demonstration.closed),
    }
    for index, thing in enumerate(demonstration.things):
        flat = pa.array(demonstration.positions[:, index].reshape(-1))
        columns[f"position.{thing.name}"] = pa.FixedSizeListArray.from_arrays(flat, type=vector)
    header = {
        "format": FORMAT,
        "version": VERSION,
        "things": [asdict(thing) for thing in demonstration.things],
        "notes": dict(demonstration.notes),
    }
    table = pa.table(columns).replace_schema_metadata({FORMAT: json.dumps(header)})
    with written_whole(path) as partial:
        parquet.write_table(table, partial)


def read_demonstration(path: Path) -> Demonstration:
    """Raises `NtpError`, with what was expected and found, for anything but a whole demonstration."""
    import pyarrow as pa
    from pyarrow import parquet

    if not path.is_file():
        raise NtpError(f"{path}: no such demonstration; `ntp record` makes them")
    try:
        table = parquet.read_table(path)
    except (pa.ArrowException, OSError) as error:
        raise NtpError(
            f"{path}: expected a demonstration (Parquet), found something else or a truncated file"
        ) from error
    header = _header(table, path)
    try:
        things = tuple(Thing.from_json(row) for row in header["things"])
        positions = [_vectors(table, f"position.{thing.name}") for thing in things]
        times = table["time"].to_numpy().astype(np.float32)
        closed = table["closed"].to_numpy(zero_copy_only=False).astype(bool)
        stacked = np.stack(positions, axis=1)  # (T, N, 3)
    except (KeyError, TypeError, ValueError, AttributeError, pa.ArrowException) as error:
        raise NtpError(f"{path}: the demonstration lacks a column or a field: {error}") from error
    if not len(times) or not np.isfinite(stacked).all():
        raise NtpError(f"{path}: expected frames of finite positions, found none or NaN")
    return Demonstration(things, stacked, closed, times, header.get("notes", {}))


def _header(table: Any, path: Path) -> dict[str, Any]:
    try:
        header = json.loads((table.schema.metadata or {})[FORMAT.encode()])
    except (KeyError, ValueError) as error:
        found = ", ".join(table.column_names[:4])
        raise NtpError(
            f"{path}: expected a demonstration of `ntp record`, found a table of {found}"
        ) from error
    if not isinstance(header, dict) or header.get("version") != VERSION:
        raise NtpError(f"{path}: expected version {VERSION} of the format, found another")
    return header


def _vectors(table: Any, column: str) -> NDArray[np.float32]:
    flat = np.asarray(table[column].combine_chunks().flatten(), dtype=np.float32)
    return flat.reshape(-1, 3)
