"""Writes a trace line by line: what has happened is on its way to the disk before the next thing does."""

from __future__ import annotations

import json
from collections.abc import Mapping
from functools import lru_cache
from typing import IO, TYPE_CHECKING, Any

from ntp_dsl.semantics.observation import Argument, Observation, Vector
from ntp_dsl.traces.schema import FORMAT, VERSION, to_json

if TYPE_CHECKING:
    from ntp_dsl.demonstrations.demonstration import Scope

DIGITS = 5  # of positions [m] and times [s]
STILL = 0.0005  # [m] below which a thing counts as where it was in the frame before

_encode = json.JSONEncoder(separators=(",", ":"), default=str).encode


class TraceWriter:
    """Writes each step as it happens; with no stream it only counts."""

    def __init__(self, stream: IO[str] | None = None) -> None:
        self._stream = stream
        self._next_call = 0
        self._latest: Observation | None = None
        self._state = -1
        self.frames = 0  # of motion, so far
        self._shown: dict[str, Vector] = {}

    def header(self, **facts: Any) -> None:
        self._write({"event": "header", "format": FORMAT, "version": VERSION, **facts})

    def state(self, observation: Observation) -> int:
        """The number of this state; consecutive equal ones are written once."""
        if observation is not self._latest and observation != self._latest:
            self._latest, self._state = observation, self._state + 1
            if self._stream is not None:
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
        if self._stream is not None:
            row = {"event": "call", "id": number, "parent": parent, "kind": kind, "name": name}
            row |= {"arguments": [to_json(a) for a in arguments], "scope": scope}
            self._write(row | {"frame": frame, "state": state, "decision": decision})
        return number

    def returned(self, number: int, outcome: str, frame: int, **details: Any) -> None:
        self._write({"event": "return", "id": number, "outcome": outcome, "frame": frame, **details})

    def frame(self, time: float, observation: Observation) -> int:
        """A moment of the motion: what moved since the one before. Returns its number.

        Formatted by hand, and left to the next step to be flushed: there are ten a second.
        """
        number, self.frames = self.frames, self.frames + 1
        if self._stream is not None:
            moved = {
                name: place
                for name, place in observation.positions.items()
                if (before := self._shown.get(name)) is None or _apart(before, place) > STILL
            }
            self._shown.update(moved)
            places = ",".join(f"{_quoted(name)}:{_triple(place)}" for name, place in moved.items())
            hand, closed = _triple(observation.gripper), str(bool(observation.closed)).lower()
            self._stream.write(
                f'{{"event":"frame","id":{number},"time":{time:.3f},"moved":{{{places}}},'
                f'"gripper":{hand},"closed":{closed}}}\n'
            )
        return number

    def picture(self, frame: int, file: str) -> None:
        """What a camera saw at a frame: a file, by its path from the trace's own folder."""
        self._write({"event": "picture", "frame": frame, "file": file})

    def end(self, **facts: Any) -> None:
        self._write({"event": "end", **facts})

    def _write(self, row: Mapping[str, Any]) -> None:
        if self._stream is not None:
            self._stream.write(_encode(row) + "\n")
            self._stream.flush()


def _apart(a: Vector, b: Vector) -> float:
    return max(abs(a[0] - b[0]), abs(a[1] - b[1]), abs(a[2] - b[2]))


@lru_cache(maxsize=1000)
def _quoted(name: str) -> str:
    return _encode(name)


def _triple(point: Vector) -> str:
    return f"[{point[0]:.5f},{point[1]:.5f},{point[2]:.5f}]"


def _place(point: Vector) -> list[float]:
    return [round(float(x), DIGITS) for x in point]


def _places(positions: Mapping[str, Vector]) -> dict[str, list[float]]:
    return {name: _place(position) for name, position in positions.items()}


def _state_row(observation: Observation) -> dict[str, Any]:
    row: dict[str, Any] = {"positions": _places(observation.positions)}
    row |= {"gripper": _place(observation.gripper), "closed": observation.closed}
    if observation.unreachable:
        row["unreachable"] = sorted(observation.unreachable)
    if observation.tipped:
        row["tipped"] = _places(observation.tipped)
    return row
