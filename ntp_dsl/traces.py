"""Execution traces: one schema for scripted and learned programs, written as it happens.

A trace is a file of JSON lines. The first is the header; then `call` and `return` lines in the order of
execution, `state` lines that calls refer to, and at last an `end` line. A line is whole or it is not there.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import IO, TYPE_CHECKING, Any

from ntp_dsl.language.diagnostics import NtpError
from ntp_dsl.world import Argument, Observation, Record, Thing

if TYPE_CHECKING:  # so that reading a trace does not wait for numpy
    from ntp_dsl.specification import Scope

FORMAT = "ntp-trace"
VERSION = 1
ROOT = -1


@dataclass
class Call:
    """A call in a trace, with what came of it."""

    id: int
    parent: int  # ROOT for the task's own program
    kind: str  # program, api
    name: str
    arguments: tuple[Argument, ...]
    scope: Scope | None
    frame: int  # of the episode, when the call was made
    state: int  # the line of states that the decision was made in
    decision: Mapping[str, Any] = field(default_factory=dict)
    end_frame: int | None = None
    outcome: str = ""  # done, unfinished, achieved, or a failure's name
    details: Mapping[str, Any] = field(default_factory=dict)


@dataclass
class Trace:
    """A trace read back."""

    header: Mapping[str, Any]
    calls: list[Call]
    states: list[Observation]
    end: Mapping[str, Any] | None  # None where the writer was cut off

    def children(self, parent: int) -> list[Call]:
        return [call for call in self.calls if call.parent == parent]


class TraceWriter:
    """Writes each step as it happens; with no stream it only counts."""

    def __init__(self, stream: IO[str] | None = None) -> None:
        self._stream = stream
        self._next_call = 0
        self._latest: Observation | None = None
        self._state = -1

    def header(self, **facts: Any) -> None:
        self._write({"event": "header", "format": FORMAT, "version": VERSION, **facts})

    def state(self, observation: Observation) -> int:
        """The number of this state; consecutive equal ones are written once."""
        if observation != self._latest:
            self._latest, self._state = observation, self._state + 1
            self._write({"event": "state", "id": self._state, **_state_row(observation)})
        return self._state

    def call(
        self,
        parent: int,
        kind: str,
        name: str,
        arguments: tuple[Argument, ...],
        scope: Scope | None,
        frame: int,
        state: int,
        decision: Mapping[str, Any],
    ) -> int:
        number, self._next_call = self._next_call, self._next_call + 1
        row = {"id": number, "parent": parent, "kind": kind, "name": name}
        row |= {"arguments": [to_json(a) for a in arguments], "scope": scope}
        self._write({"event": "call", **row, "frame": frame, "state": state, **decision})
        return number

    def returned(self, number: int, outcome: str, frame: int, **details: Any) -> None:
        self._write(
            {"event": "return", "id": number, "outcome": outcome, "frame": frame, **details}
        )

    def end(self, **facts: Any) -> None:
        self._write({"event": "end", **facts})

    def _write(self, row: Mapping[str, Any]) -> None:
        if self._stream is not None:
            self._stream.write(json.dumps(row, separators=(",", ":"), default=str) + "\n")
            self._stream.flush()


def read_trace(path: Path) -> Trace:
    """Up to the last whole line. Raises `NtpError` for what is not a trace, or of another version."""
    try:
        return parse_trace(path.read_bytes(), path)
    except OSError as error:
        raise NtpError(f"{path}: cannot be read: {error.strerror}") from error


def parse_trace(text: bytes, path: Path) -> Trace:
    rows = list(_rows(text.split(b"\n"), path))
    if not rows:
        raise NtpError(f"{path}: expected a trace (JSON lines) of `ntp`, found not one whole line")
    header = rows[0]
    if header.get("format") != FORMAT:
        raise NtpError(f"{path}: expected a trace (JSON lines) of `ntp`, found something else")
    if header.get("version") != VERSION:
        raise NtpError(f"{path}: expected version {VERSION}, found {header.get('version')}")
    try:
        return _assemble(rows)
    except (KeyError, TypeError, ValueError, IndexError) as error:
        raise NtpError(f"{path}: a line of the trace lacks a field: {error!r}") from error


def _rows(lines: list[bytes], path: Path) -> Iterator[dict[str, Any]]:
    for number, line in enumerate(lines[:-1], 1):  # what follows the last newline was cut off
        try:
            row = json.loads(line)
        except (ValueError, RecursionError) as error:
            raise NtpError(f"{path}:{number}: expected a line of JSON, found {line[:40]!r}") from error
        if not isinstance(row, dict):
            raise NtpError(f"{path}:{number}: expected a JSON object, found {line[:40]!r}")
        yield row


def _assemble(rows: list[dict[str, Any]]) -> Trace:
    header = rows[0]
    things = tuple(Thing(t["name"], t["type"], tuple(t["size"])) for t in header["things"])
    trace = Trace(header, [], [], None)
    for row in rows[1:]:
        event = row.pop("event")
        if event == "state":
            trace.states.append(_observation(row, things))
        elif event == "call":
            trace.calls.append(_call(row))
        elif event == "return":
            done = trace.calls[row.pop("id")]
            done.outcome, done.end_frame = row.pop("outcome"), row.pop("frame")
            done.details = row
        elif event == "end":
            trace.end = row
    return trace


def _call(row: dict[str, Any]) -> Call:
    scope = tuple(row.pop("scope") or ()) or None
    arguments = tuple(from_json(a) for a in row.pop("arguments"))
    known = {name: row.pop(name) for name in ("id", "parent", "kind", "name", "frame", "state")}
    return Call(**known, arguments=arguments, scope=scope, decision=row)


def _state_row(observation: Observation) -> dict[str, Any]:
    rounded = {
        name: [round(float(x), 5) for x in position]
        for name, position in observation.positions.items()
    }
    row: dict[str, Any] = {"positions": rounded}
    row["gripper"] = [round(float(x), 5) for x in observation.gripper]
    row["closed"] = observation.closed
    if observation.unreachable:
        row["unreachable"] = sorted(observation.unreachable)
    return row


def _observation(row: Mapping[str, Any], things: tuple[Thing, ...]) -> Observation:
    positions = {name: tuple(position) for name, position in row["positions"].items()}
    unreachable = frozenset(row.get("unreachable", ()))
    return Observation(things, positions, tuple(row["gripper"]), row["closed"], unreachable)


def to_json(argument: Argument) -> Any:
    if isinstance(argument, Record):
        return {"record": argument.type, **dict(argument.fields)}
    if isinstance(argument, tuple):
        return [to_json(element) for element in argument]
    return argument


def from_json(value: Any) -> Argument:
    if isinstance(value, dict):
        fields = tuple((k, str(v)) for k, v in value.items() if k != "record")
        return Record(value["record"], fields)
    if isinstance(value, list):
        return tuple(from_json(element) for element in value)  # type: ignore[misc]
    if isinstance(value, str | int | float):
        return value
    raise ValueError(f"{value!r} is not an argument")
