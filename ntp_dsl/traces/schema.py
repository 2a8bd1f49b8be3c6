"""What a trace is made of: calls in the order of execution, the states they were decided in, and frames."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from math import isfinite
from typing import TYPE_CHECKING, Any

from ntp_dsl.semantics.observation import Argument, Observation, Record, Thing, Vector

if TYPE_CHECKING:  # so that reading a trace does not wait for numpy
    from ntp_dsl.demonstrations.demonstration import Scope

FORMAT = "ntp-trace"
VERSION = 2
ROOT = -1
WELL = ("done", "achieved")  # outcomes; what else a call may come to did not do what it should


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
    decision: Mapping[str, Any] = field(default_factory=dict)  # to make this call, by its caller
    end_frame: int | None = None
    end_state: int | None = None  # that a program decided to return in
    outcome: str = ""  # done, unfinished, achieved, stopped, or a failure's name; empty where cut off
    ending: Mapping[str, Any] = field(default_factory=dict)  # a program's decision to return
    details: Mapping[str, Any] = field(default_factory=dict)  # of a primitive: times, evidence, …

    @property
    def is_program(self) -> bool:
        return self.kind == "program"

    @property
    def went_well(self) -> bool:
        return self.outcome in WELL

    @property
    def probability(self) -> float | None:
        """Of the decision to make this call; None where a script made it."""
        value = self.decision.get("probability")
        return float(value) if isinstance(value, int | float) and isfinite(value) else None

    @property
    def disturbances(self) -> tuple[str, ...]:
        value = self.details.get("disturbances")
        return tuple(map(str, value)) if isinstance(value, list) else ()


@dataclass(frozen=True)
class Motion:
    """What moved up to a frame of the episode, since the one before; one frame is a tenth of a second."""

    frame: int
    time: float  # [s] since the reset
    positions: Mapping[str, Vector]  # of what moved
    gripper: Vector
    closed: bool


@dataclass
class Trace:
    """A trace read back."""

    header: Mapping[str, Any]
    things: tuple[Thing, ...] = ()
    calls: list[Call] = field(default_factory=list)
    states: Sequence[Observation] = ()
    motions: list[Motion] = field(default_factory=list)
    pictures: list[tuple[int, str]] = field(default_factory=list)  # frame, file beside the trace
    end: Mapping[str, Any] | None = None  # None where the writer was cut off

    @cached_property
    def _offspring(self) -> list[list[int]]:
        """Numbers of the calls that each call made; those of the root come last."""
        found: list[list[int]] = [[] for _ in range(len(self.calls) + 1)]
        for call in self.calls:
            found[call.parent].append(call.id)
        return found

    def children(self, parent: int) -> list[Call]:
        """The calls that a call made, or the root calls for `ROOT`."""
        return [self.calls[number] for number in self._offspring[parent]]

    def ancestors(self, number: int) -> Iterator[Call]:
        """The call, its caller, and so on to the root."""
        while number != ROOT:
            call = self.calls[number]
            yield call
            number = call.parent

    def events(self) -> Iterator[tuple[Call, bool]]:
        """Calls and returns in the order of execution: a call, and whether it returns."""
        running: list[Call] = []
        for call in self.calls:
            while running and running[-1].id != call.parent:
                yield running.pop(), True
            yield call, False
            running.append(call)
        yield from ((call, True) for call in reversed(running) if call.outcome)

    @property
    def is_replayed(self) -> bool:
        """Whether it holds what a policy answered at every state of another trace."""
        return self.header.get("policy") == "replayed"

    @property
    def is_learned(self) -> bool:
        """Whether a core decided, or answered."""
        return self.header.get("policy") == "learned" or self.header.get("model") is not None


def to_json(argument: Argument) -> Any:
    if isinstance(argument, Record):
        return {"record": argument.type, **dict(argument.fields)}
    if isinstance(argument, tuple):
        return [to_json(element) for element in argument]
    return argument


def from_json(value: Any) -> Argument:
    """Raises `ValueError` for what is no argument."""
    if isinstance(value, dict) and isinstance(value.get("record"), str):
        entries = tuple((k, v if isinstance(v, float) else str(v)) for k, v in value.items() if k != "record")
        return Record(value["record"], entries)
    if isinstance(value, list):
        return tuple(from_json(element) for element in value)  # type: ignore[misc]
    if isinstance(value, str | float) or type(value) is int:
        return value
    raise ValueError(f"{value!r:.80} is not an argument")


def thing_from_json(row: Mapping[str, Any]) -> Thing:
    """What a thing says of itself, without what this version does not know. Raises `ValueError`."""
    if not isinstance(row.get("name"), str) or not isinstance(row.get("type"), str):
        raise ValueError("a thing has a name and a type")
    return Thing.from_json({**row, "size": vector(row.get("size"))})


def vector(value: Any) -> Vector:
    """Three finite numbers. Raises `ValueError`."""
    if isinstance(value, list) and len(value) == 3:
        x, y, z = value
        if all(isinstance(n, int | float) and isfinite(n) for n in value):
            return float(x), float(y), float(z)
    raise ValueError(f"expected three numbers, found {value!r:.80}")
