"""Reads a trace up to its last complete line, and reports what is wrong with an invalid one.

Unknown events and fields are skipped. The rest is checked: calls are numbered in order, nest, and refer to
states that exist.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import lru_cache
from pathlib import Path
from typing import Any, overload

import msgspec

from ntp_dsl.common.decoding import Unreadable, decoding
from ntp_dsl.common.text import printable
from ntp_dsl.language.diagnostics.diagnostics import NtpError
from ntp_dsl.semantics.observation import Observation, SceneObject
from ntp_dsl.traces.events import (
    CallEvent,
    Event,
    FrameEvent,
    PictureEvent,
    ReturnEvent,
    StateEvent,
)
from ntp_dsl.traces.old_versions import OLDEST, Upgrade, old_row
from ntp_dsl.traces.schema import FORMAT, MAX_DEPTH, ROOT, VERSION, Call, End, Header, Motion
from ntp_dsl.traces.trace import Trace

EVENTS: dict[str, type[Any]] = {
    "header": Header,
    "state": StateEvent,
    "call": CallEvent,
    "return": ReturnEvent,
    "frame": FrameEvent,
    "picture": PictureEvent,
    "end": End,
}
DECODERS = {name: msgspec.json.Decoder(event) for name, event in EVENTS.items()}


class _Named(msgspec.Struct):
    """The kind of a line."""

    event: str


class _Versioned(msgspec.Struct):
    """The part of the first line that all versions share."""

    format: Any = None
    version: Any = None


_named, _versioned = msgspec.json.Decoder(_Named), msgspec.json.Decoder(_Versioned)


class Unstarted(NtpError):
    """The file has no whole line: its writer was killed before the first."""


def read_trace(path: Path | str) -> Trace:
    """Read a file up to its last complete line. Raises `NtpError` where it is not a trace."""
    path = Path(path)
    try:
        return parse_trace(path.read_bytes(), path)
    except OSError as error:
        raise NtpError(f"{path}: cannot be read: {error.strerror}") from error


def parse_trace(text: bytes, path: Path) -> Trace:
    """Read the text of a file; the path is for error messages."""
    lines = text[: text.rfind(b"\n") + 1].splitlines()  # what follows the last newline was cut off
    if not lines:
        raise Unstarted(f"{path}: expected a trace (JSON lines) of `ntp`, found no complete line")
    builder = _TraceBuilder()
    for number, event in _events(lines, path):
        try:
            builder.add(event)
        except ValueError as error:
            raise NtpError(f"{path}:{number}: not a line of a trace: {error}") from error
    return builder.trace


def _events(lines: Sequence[bytes], path: Path) -> Iterator[tuple[int, Event]]:
    """Yield the known events, each with its line number."""
    upgrade = _upgrade(lines[0], path)
    for number, line in enumerate(lines, 1):
        try:
            with decoding():
                event = _header(line, upgrade) if number == 1 else _event(line, upgrade)
        except (Unreadable, NtpError) as error:
            raise NtpError(f"{path}:{number}: not a line of a trace: {error}") from error
        if event is not None:
            yield number, event


def _upgrade(first: bytes, path: Path) -> Upgrade | None:
    """Return the converter of an old version; None for the current one. Raises `NtpError` for others."""
    try:
        with decoding():
            header = _versioned.decode(first)
    except Unreadable as error:
        raise NtpError(f"{path}:1: expected a trace (JSON lines) of `ntp`, found {first[:40]!r}") from error
    if header.format != FORMAT:
        raise NtpError(f"{path}: expected a trace (JSON lines) of `ntp`, found something else")
    if type(header.version) is int and OLDEST <= header.version <= VERSION:
        return None if header.version == VERSION else Upgrade(header.version)
    newer = type(header.version) is int and header.version > VERSION
    advice = "it was written by a newer ntp: update ntp" if newer else "record it again"
    found = printable(repr(header.version)[:40])
    raise NtpError(f"{path}: expected version {VERSION} of the format, found {found}; {advice}")


def _header(line: bytes, upgrade: Upgrade | None) -> Event:
    if upgrade is not None:
        return msgspec.convert(upgrade.row(old_row(line) | {"event": "header"}), Header)
    header: Header = DECODERS["header"].decode(line)
    return header


def _event(line: bytes, upgrade: Upgrade | None) -> Event | None:
    if upgrade is not None:
        return _old_event(line, upgrade)
    name = _named.decode(line).event
    return DECODERS[name].decode(line) if name in EVENTS else None


def _old_event(line: bytes, upgrade: Upgrade) -> Event | None:
    row = old_row(line)
    name = msgspec.convert(row, _Named).event
    return msgspec.convert(upgrade.row(row), EVENTS[name]) if name in EVENTS else None


class _TraceBuilder:
    """A trace under construction, and the calls that are still open."""

    def __init__(self) -> None:
        self.states = States()
        self.trace = Trace(Header(format=FORMAT, version=VERSION), states=self.states)
        self._has_header = False
        self._running: list[Call] = []

    def add(self, event: Event) -> None:
        """Add the next event. Raises `ValueError` where it does not follow from the previous ones."""
        match event:
            case Header():
                _expect(not self._has_header, "a second header")
                reference = event.demonstration
                if reference is not None and reference.calls is not None:
                    _expect(reference.calls.depth <= MAX_DEPTH, "its demonstration has too many nested calls")
                self.trace.header, self.states.objects, self._has_header = event, event.objects, True
            case StateEvent():
                _expect(event.id == len(self.states), f"expected state {len(self.states)}")
                self.states.append(event)
            case CallEvent():
                self._call(event)
            case ReturnEvent():
                self._return(event)
            case FrameEvent():
                _expect(event.id == len(self.trace.motions), f"expected frame {len(self.trace.motions)}")
                moment = Motion(event.id, event.time, event.moved, event.gripper, event.closed)
                self.trace.motions.append(moment)
            case PictureEvent():
                self.trace.pictures.append((event.frame, event.file))
            case End():
                self.trace.end = event

    def _call(self, event: CallEvent) -> None:
        number = len(self.trace.calls)
        _expect(event.id == number, f"expected call {number}, found {event.id}")
        caller = self._running[-1].id if self._running else ROOT
        _expect(event.parent == caller, f"call {number} is made by {event.parent}, but {caller} is running")
        _expect(caller == ROOT or self._running[-1].is_program, "a primitive cannot make calls")
        _expect(event.scope is None or event.scope[0] <= event.scope[1], "expected a scope of [begin, end)")
        _expect(len(self._running) < MAX_DEPTH, f"more than {MAX_DEPTH} nested calls")
        self._check_state(event.state)
        call = Call(
            number,
            event.parent,
            event.kind,
            event.name,
            event.arguments,
            event.scope,
            event.frame,
            event.state,
            event.decision,
        )
        self.trace.calls.append(call)
        self._running.append(call)

    def _return(self, event: ReturnEvent) -> None:
        _expect(bool(self._running), f"call {event.id} returns, but none is running")
        call = self._running.pop()
        _expect(call.id == event.id, f"call {event.id} returns, but {call.id} is running")
        if event.state is not None:
            self._check_state(event.state)
        call.outcome, call.end_frame, call.end_state = event.outcome, event.frame, event.state
        call.return_decision, call.execution = event.decision, event.execution

    def _check_state(self, number: int) -> None:
        _expect(number < len(self.states), f"there is no state {number} before this line")


class States(Sequence[Observation]):
    """Observations that are built on access, since most readers look at few."""

    def __init__(self) -> None:
        self.objects: tuple[SceneObject, ...] = ()
        self._events: list[StateEvent] = []
        self._observation = lru_cache(maxsize=64)(
            lambda number: self._events[number].observation(self.objects)
        )

    def append(self, event: StateEvent) -> None:
        """Add the next state."""
        self._events.append(event)

    def __len__(self) -> int:
        return len(self._events)

    @overload
    def __getitem__(self, index: int) -> Observation: ...
    @overload
    def __getitem__(self, index: slice) -> list[Observation]: ...
    def __getitem__(self, index: int | slice) -> Observation | list[Observation]:
        if isinstance(index, slice):
            return [self._observation(number) for number in range(*index.indices(len(self)))]
        return self._observation(range(len(self))[index])

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Sequence) and list(self) == list(other)


def _expect(truth: bool, sentence: str) -> None:
    if not truth:
        raise ValueError(sentence)
