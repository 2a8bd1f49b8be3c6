"""Reads a trace up to its last whole line, and says what is wrong with what is not one.

Fields that this version does not know are passed over, and so are events; what a trace has to say it must say
soundly: calls are numbered in their order, nest, and refer to states that are there.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import lru_cache
from pathlib import Path
from typing import Any, overload

import msgspec

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
from ntp_dsl.traces.old_versions import OLDEST, Upgrade
from ntp_dsl.traces.schema import FORMAT, ROOT, VERSION, Call, End, Header, Motion, Trace

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
LONGEST = 200  # characters of a message


class _Named(msgspec.Struct):
    """Which event a line is."""

    event: str


class _Versioned(msgspec.Struct):
    """What the first line of every version says."""

    format: Any = None
    version: Any = None


_named, _versioned = msgspec.json.Decoder(_Named), msgspec.json.Decoder(_Versioned)


def read_trace(path: Path) -> Trace:
    """Read a file up to its last whole line. Raises `NtpError` for what is not a trace."""
    try:
        return parse_trace(path.read_bytes(), path)
    except OSError as error:
        raise NtpError(f"{path}: cannot be read: {error.strerror}") from error


def parse_trace(text: bytes, path: Path) -> Trace:
    """Read the text of a file; the path is for its errors."""
    lines = text[: text.rfind(b"\n") + 1].splitlines()  # what follows the last newline was cut off
    if not lines:
        raise NtpError(f"{path}: expected a trace (JSON lines) of `ntp`, found not one whole line")
    assembly = _Assembly()
    for number, event in _events(lines, path):
        try:
            assembly.take(event)
        except ValueError as error:
            raise NtpError(f"{path}:{number}: not a line of a trace: {error}") from error
    return assembly.trace


def _events(lines: Sequence[bytes], path: Path) -> Iterator[tuple[int, Event]]:
    """Yield the events that are known, each with its line's number."""
    upgrade = _upgrade(lines[0], path)
    for number, line in enumerate(lines, 1):
        try:
            event = _header(line, upgrade) if number == 1 else _event(line, upgrade)
        except msgspec.ValidationError as error:
            raise NtpError(f"{path}:{number}: not a line of a trace: {str(error)[:LONGEST]}") from error
        except (msgspec.DecodeError, UnicodeDecodeError) as error:
            raise NtpError(f"{path}:{number}: expected a line of JSON, found {line[:40]!r}") from error
        except RecursionError as error:
            raise NtpError(f"{path}:{number}: not a line of a trace: it is nested too deeply") from error
        if event is not None:
            yield number, event


def _upgrade(first: bytes, path: Path) -> Upgrade | None:
    """Return what makes lines of an old version new ones; None where they are new."""
    try:
        said = _versioned.decode(first)
    except (msgspec.MsgspecError, UnicodeDecodeError, RecursionError) as error:
        raise NtpError(f"{path}:1: expected a trace (JSON lines) of `ntp`, found {first[:40]!r}") from error
    if said.format != FORMAT:
        raise NtpError(f"{path}: expected a trace (JSON lines) of `ntp`, found something else")
    if type(said.version) is int and OLDEST <= said.version <= VERSION:
        return None if said.version == VERSION else Upgrade(said.version)
    newer = type(said.version) is int and said.version > VERSION
    advice = "a newer ntp made it: update ntp" if newer else "make it anew"
    raise NtpError(f"{path}: expected version {VERSION} of the format, found {said.version!r:.40}; {advice}")


def _header(line: bytes, upgrade: Upgrade | None) -> Event:
    if upgrade is not None:
        return msgspec.convert(upgrade.row(msgspec.json.decode(line) | {"event": "header"}), Header)
    header: Header = DECODERS["header"].decode(line)
    return header


def _event(line: bytes, upgrade: Upgrade | None) -> Event | None:
    name = _named.decode(line).event
    if name not in EVENTS:
        return None
    if upgrade is not None:
        return msgspec.convert(upgrade.row(msgspec.json.decode(line)), EVENTS[name])  # type: ignore[no-any-return]
    return DECODERS[name].decode(line)  # type: ignore[no-any-return]


class _Assembly:
    """A trace in the making, and the calls that are still running."""

    def __init__(self) -> None:
        self.states = States()
        self.trace = Trace(Header(format=FORMAT, version=VERSION), states=self.states)
        self._has_header = False
        self._running: list[Call] = []

    def take(self, event: Event) -> None:
        """Add the next event. Raises `ValueError` where it does not fit those before."""
        match event:
            case Header():
                _expect(not self._has_header, "a second header")
                self.trace.header, self.states.objects, self._has_header = event, event.objects, True
            case StateEvent():
                _expect(event.id == len(self.states), f"expected state {len(self.states)}")
                self.states.append(event)
            case CallEvent():
                self._call(event)
            case ReturnEvent():
                self._return(event)
            case FrameEvent():
                _expect(event.id == len(self.trace.motions), "frames are numbered in their order")
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
        _expect(caller == ROOT or self._running[-1].is_program, "a primitive calls nothing")
        _expect(event.scope is None or event.scope[0] <= event.scope[1], "expected a scope of [begin, end)")
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
        call.ending, call.execution = event.decision, event.execution

    def _check_state(self, number: int) -> None:
        _expect(number < len(self.states), f"there is no state {number} before this line")


class States(Sequence[Observation]):
    """Made into observations when they are asked for: most readers look at few."""

    def __init__(self) -> None:
        self.objects: tuple[SceneObject, ...] = ()
        self._events: list[StateEvent] = []
        self._made = lru_cache(maxsize=64)(lambda number: self._events[number].observation(self.objects))

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
            return [self._made(number) for number in range(*index.indices(len(self)))]
        return self._made(range(len(self))[index])

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Sequence) and list(self) == list(other)


def _expect(truth: bool, sentence: str) -> None:
    if not truth:
        raise ValueError(sentence)
