"""Reads a trace up to its last whole line, and says what is wrong with what is not one.

Fields that this version does not know are passed over, and so are events; what a trace has to say it must say
soundly: calls are numbered in their order, nest, and refer to states that are there.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import lru_cache
from itertools import chain
from pathlib import Path
from typing import Any, overload

from ntp_dsl.language.diagnostics.diagnostics import NtpError
from ntp_dsl.semantics.observation import Observation, Thing
from ntp_dsl.traces.schema import (
    FORMAT,
    ROOT,
    VERSION,
    Call,
    Motion,
    Trace,
    from_json,
    thing_from_json,
    vector,
)

Row = dict[str, Any]
DEEP = RecursionError  # of a line whose lists hold lists, and so on


def read_trace(path: Path) -> Trace:
    """Up to the last whole line. Raises `NtpError` for what is not a trace, or of another version."""
    try:
        return parse_trace(path.read_bytes(), path)
    except OSError as error:
        raise NtpError(f"{path}: cannot be read: {error.strerror}") from error


def parse_trace(text: bytes, path: Path) -> Trace:
    """Of the text of a file; the path is for its errors."""
    rows = _rows(text, path)
    first, header = next(rows, (0, {}))
    if not first:
        raise NtpError(f"{path}: expected a trace (JSON lines) of `ntp`, found not one whole line")
    if header.get("format") != FORMAT:
        raise NtpError(f"{path}: expected a trace (JSON lines) of `ntp`, found something else")
    _check_version(header.get("version"), path)
    assembly = _Assembly()
    for number, row in chain([(first, {"event": "header"} | header)], rows):
        try:
            assembly.take(row)
        except (KeyError, TypeError, ValueError, DEEP) as error:
            raise NtpError(f"{path}:{number}: not a line of a trace: {_told(error)}") from error
    return assembly.trace


def _check_version(found: Any, path: Path) -> None:
    if found == VERSION:
        return
    newer = isinstance(found, int) and found > VERSION
    advice = "a newer ntp made it: update ntp" if newer else "make it anew"
    raise NtpError(f"{path}: expected version {VERSION} of the format, found {found!r:.40}; {advice}")


def _rows(text: bytes, path: Path) -> Iterator[tuple[int, Row]]:
    whole = text[: text.rfind(b"\n") + 1]  # what follows the last newline was cut off
    for number, line in enumerate(whole.splitlines(), 1):
        try:
            row = json.loads(line, parse_constant=_no_number)
        except (ValueError, DEEP) as error:
            raise NtpError(f"{path}:{number}: expected a line of JSON, found {line[:40]!r}") from error
        if not isinstance(row, dict):
            raise NtpError(f"{path}:{number}: expected a JSON object, found {line[:40]!r}")
        yield number, row


def _no_number(name: str) -> None:
    """NaN and the infinities are not JSON, and nothing that is measured is one of them."""


def _told(error: Exception) -> str:
    if isinstance(error, KeyError):
        return f"it lacks {error}"
    return "it is nested too deeply" if isinstance(error, DEEP) else str(error)


class _Assembly:
    """A trace in the making, and the calls that are still running."""

    def __init__(self) -> None:
        self.states = States()
        self.trace = Trace({}, states=self.states)
        self._running: list[Call] = []
        self._takers: Mapping[str, Callable[[Row], None]] = {
            "header": self._header,
            "call": self._call,
            "return": self._return,
            "state": self._state,
            "frame": self._frame,
            "picture": self._picture,
            "end": self._end,
        }

    def take(self, row: Row) -> None:
        event = row["event"]
        if isinstance(event, str) and event in self._takers:
            self._takers[event](row)

    def _header(self, row: Row) -> None:
        _expect(not self.trace.header, "a second header")
        things = tuple(thing_from_json(each) for each in _list(row, "things"))
        self.trace.header, self.trace.things, self.states.things = row, things, things

    def _call(self, row: Row) -> None:
        number, parent = len(self.trace.calls), _count(row, "parent", ROOT)
        _expect(_count(row, "id") == number, f"expected call {number}, found {row['id']}")
        caller = self._running[-1].id if self._running else ROOT
        _expect(parent == caller, f"call {number} is made by {parent}, but {caller} is running")
        _expect(caller == ROOT or self._running[-1].is_program, "a primitive calls nothing")
        kind = _text(row, "kind")
        _expect(kind in ("program", "api"), f"expected a program or an api, found {kind!r:.40}")
        call = Call(
            number,
            parent,
            kind,
            _text(row, "name"),
            tuple(from_json(value) for value in _list(row, "arguments")),
            _scope(row.get("scope")),
            _count(row, "frame"),
            self._known_state(_count(row, "state")),
            _mapping(row, "decision"),
        )
        self.trace.calls.append(call)
        self._running.append(call)

    def _return(self, row: Row) -> None:
        number = _count(row, "id")
        _expect(bool(self._running), f"call {number} returns, but none is running")
        call = self._running.pop()
        _expect(call.id == number, f"call {number} returns, but {call.id} is running")
        call.outcome, call.end_frame = _text(row, "outcome"), _count(row, "frame")
        call.ending = _mapping(row, "decision")
        if "state" in row:
            call.end_state = self._known_state(_count(row, "state"))
        known = {"event", "id", "outcome", "frame", "decision", "state"}
        call.details = {name: value for name, value in row.items() if name not in known}

    def _state(self, row: Row) -> None:
        _expect(_count(row, "id") == len(self.states), f"expected state {len(self.states)}")
        self.states.append(row)

    def _frame(self, row: Row) -> None:
        moved = {name: vector(place) for name, place in _mapping(row, "moved").items()}
        time, closed = row["time"], row["closed"]
        _expect(isinstance(time, int | float) and 0 <= time < 1e9, "expected time in seconds")
        _expect(isinstance(closed, bool), "expected closed to be true or false")
        motion = Motion(_count(row, "id"), float(time), moved, vector(row["gripper"]), closed)
        _expect(motion.frame == len(self.trace.motions), "frames are numbered in their order")
        self.trace.motions.append(motion)

    def _picture(self, row: Row) -> None:
        self.trace.pictures.append((_count(row, "frame"), _text(row, "file")))

    def _end(self, row: Row) -> None:
        self.trace.end = {name: value for name, value in row.items() if name != "event"}

    def _known_state(self, number: int) -> int:
        _expect(number < len(self.states), f"there is no state {number} before this line")
        return number


class States(Sequence[Observation]):
    """Made into observations when they are asked for: most readers look at few."""

    def __init__(self) -> None:
        self.things: tuple[Thing, ...] = ()
        self._rows: list[Row] = []
        self._made = lru_cache(maxsize=64)(self._make)

    def append(self, row: Row) -> None:
        positions = _mapping(row, "positions")
        tipped = _mapping(row, "tipped") if "tipped" in row else {}
        _expect(tipped.keys() <= {thing.name for thing in self.things}, "expected tipped things of the scene")
        for place in (*positions.values(), *tipped.values()):
            vector(place)
        vector(row["gripper"])
        _expect(isinstance(row["closed"], bool), "expected closed to be true or false")
        _expect(isinstance(row.get("unreachable", []), list), "expected a list of the unreachable")
        self._rows.append(row)

    def __len__(self) -> int:
        return len(self._rows)

    @overload
    def __getitem__(self, index: int) -> Observation: ...
    @overload
    def __getitem__(self, index: slice) -> list[Observation]: ...
    def __getitem__(self, index: int | slice) -> Observation | list[Observation]:
        if isinstance(index, slice):
            return [self._made(number) for number in range(*index.indices(len(self)))]
        return self._made(range(len(self))[index])

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Sequence) and list(self) == list(other)

    def _make(self, number: int) -> Observation:
        row = self._rows[number]
        positions = {name: vector(place) for name, place in row["positions"].items()}
        unreachable = frozenset(map(str, row.get("unreachable", ())))
        tipped = {name: vector(size) for name, size in row.get("tipped", {}).items()}
        return Observation(self.things, positions, vector(row["gripper"]), row["closed"], unreachable, tipped)


# What a field must be ------------------------------------------------------------------------------


def _expect(truth: bool, sentence: str) -> None:
    if not truth:
        raise ValueError(sentence)


def _count(row: Row, name: str, low: int = 0) -> int:
    value = row[name]
    _expect(type(value) is int and value >= low, f"expected {name} to be a number, found {value!r:.40}")
    return int(value)


def _text(row: Row, name: str) -> str:
    value = row[name]
    _expect(isinstance(value, str), f"expected {name} to be a text, found {value!r:.40}")
    return str(value)


def _list(row: Row, name: str) -> list[Any]:
    value = row[name]
    _expect(isinstance(value, list), f"expected {name} to be a list, found {value!r:.40}")
    return list(value)


def _mapping(row: Row, name: str) -> Mapping[str, Any]:
    value = row.get(name, {})
    _expect(isinstance(value, dict), f"expected {name} to be an object, found {value!r:.40}")
    return dict(value)


def _scope(value: Any) -> tuple[int, int] | None:
    if value is None:
        return None
    whole = isinstance(value, list) and len(value) == 2 and all(type(n) is int for n in value)
    _expect(whole and 0 <= value[0] <= value[1], f"expected two frames, found {value!r:.40}")
    return value[0], value[1]
