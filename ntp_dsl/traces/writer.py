"""Writes a trace line by line, flushed at every step: a killed process loses only the step in progress."""

from __future__ import annotations

from functools import lru_cache
from typing import IO, Any

import msgspec

from ntp_dsl.semantics.geometry import Vector
from ntp_dsl.semantics.observation import Argument, Observation
from ntp_dsl.traces.decision import Decision, Frames
from ntp_dsl.traces.events import CallEvent, Event, PictureEvent, ReturnEvent, StateEvent
from ntp_dsl.traces.schema import NOT_EXECUTED, CallKind, CallOutcome, End, Execution, Header

MOTION_THRESHOLD = 0.0005  # [m] that an object moves before its position is written again


class TraceWriter:
    """Writes each step as it happens; without a stream it only counts calls and frames."""

    def __init__(self, stream: IO[str] | None = None) -> None:
        self._stream = stream
        self._next_call = 0
        self._latest: Observation | None = None
        self._state = -1
        self.frames = 0  # of motion, so far
        self._written: dict[str, Vector] = {}

    @property
    def is_open(self) -> bool:
        """Whether anything is written."""
        return self._stream is not None

    def header(self, header: Header) -> None:
        """Write the header; first and once."""
        self._write(header)

    def state(self, observation: Observation) -> int:
        """Write a state unless it equals the previous one, and return its number."""
        if observation is not self._latest and observation != self._latest:
            self._latest, self._state = observation, self._state + 1
            if self._stream is not None:
                self._write(StateEvent.of(self._state, observation))
        return self._state

    def call(
        self,
        parent: int,
        kind: CallKind,
        name: str,
        arguments: tuple[Argument, ...],
        scope: Frames | None,
        frame: int,
        state: int,
        decision: Decision,
    ) -> int:
        """Write the beginning of a call, and return its number."""
        number, self._next_call = self._next_call, self._next_call + 1
        if self._stream is not None:
            self._write(CallEvent(number, parent, kind, name, arguments, frame, state, scope, decision))
        return number

    def returned(
        self,
        number: int,
        outcome: CallOutcome,
        frame: int,
        state: int | None = None,
        decision: Decision | None = None,
        execution: Execution = NOT_EXECUTED,
    ) -> None:
        """Write the end of a call.

        Args:
            state: in which a program decided to return.
            decision: of a program to return.
            execution: of a primitive.
        """
        self._write(ReturnEvent(number, outcome, frame, state, decision, execution))

    def frame(self, time: float, observation: Observation) -> int:
        """Write the objects that moved since they were last written, and return the frame's number.

        Formatted by hand and flushed with the next step, for speed: there are ten frames per second.
        """
        number, self.frames = self.frames, self.frames + 1
        if self._stream is not None:
            moved = {
                name: place
                for name, place in observation.positions.items()
                if (before := self._written.get(name)) is None
                or _largest_difference(before, place) > MOTION_THRESHOLD
            }
            self._written.update(moved)
            places = ",".join(f"{_quoted(name)}:{_triple(place)}" for name, place in moved.items())
            hand, closed = _triple(observation.gripper), str(bool(observation.closed)).lower()
            self._stream.write(
                f'{{"event":"frame","id":{number},"time":{time:.3f},"moved":{{{places}}},'
                f'"gripper":{hand},"closed":{closed}}}\n'
            )
        return number

    def picture(self, frame: int, file: str) -> None:
        """Write the file of a frame's picture: a path relative to the trace's folder."""
        self._write(PictureEvent(frame, file))

    def end(self, end: End) -> None:
        """Write the end of the run."""
        self._write(end)

    def _write(self, event: Event) -> None:
        if self._stream is not None:
            self._stream.write(_encoder.encode(event).decode() + "\n")
            self._stream.flush()


def _plain(value: Any) -> Any:
    """Return a measurement as JSON allows it: numpy's scalars and arrays become Python's."""
    return value.tolist() if hasattr(value, "tolist") else str(value)


_encoder = msgspec.json.Encoder(enc_hook=_plain)


def _largest_difference(a: Vector, b: Vector) -> float:
    return max(abs(a[0] - b[0]), abs(a[1] - b[1]), abs(a[2] - b[2]))


@lru_cache(maxsize=1000)
def _quoted(name: str) -> str:
    return msgspec.json.encode(name).decode()


def _triple(point: Vector) -> str:
    return f"[{point[0]:.5f},{point[1]:.5f},{point[2]:.5f}]"
