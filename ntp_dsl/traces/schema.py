"""What a trace is made of: calls in the order of execution, the states they were decided in, and frames."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from enum import StrEnum
from functools import cached_property
from html import escape
from typing import TYPE_CHECKING, Any

from msgspec import Struct

from ntp_dsl.semantics.geometry import Vector
from ntp_dsl.semantics.observation import Argument, Observation, Record, SceneObject
from ntp_dsl.traces.decision import NO_DECISION, Count, Decision, Frames, Seconds
from ntp_dsl.worlds.protocol import Disturbances, Failure, Outcome

if TYPE_CHECKING:
    import pandas

FORMAT = "ntp-trace"
VERSION = 3
ROOT = -1


class CallKind(StrEnum):
    """What was called."""

    PROGRAM = "program"
    API = "api"


class PolicyKind(StrEnum):
    """Whose decisions a trace holds."""

    SCRIPTED = "scripted"
    LEARNED = "learned"
    REPLAYED = "replayed"  # a policy's answers at every state of another trace
    DEMONSTRATION = "demonstration"
    CUSTOM = "custom"  # a user's own


class CallOutcome(StrEnum):
    """What a call came to."""

    DONE = "done"  # of programs, as the next two
    UNFINISHED = "unfinished"
    STOPPED = "stopped"
    ACHIEVED = "achieved"  # of primitives, as all that follow
    NOT_READY = Failure.NOT_READY.value
    NO_IK = Failure.NO_IK.value
    START_IN_COLLISION = Failure.START_IN_COLLISION.value
    GOAL_IN_COLLISION = Failure.GOAL_IN_COLLISION.value
    NO_PATH = Failure.NO_PATH.value
    GRASP_FAILED = Failure.GRASP_FAILED.value
    OBJECT_DROPPED = Failure.OBJECT_DROPPED.value
    PLACE_FAILED = Failure.PLACE_FAILED.value
    MISSING_OBJECT = Failure.MISSING_OBJECT.value
    TIME_OUT = Failure.TIME_OUT.value

    @classmethod
    def of(cls, outcome: Outcome) -> CallOutcome:
        """Return the outcome of a primitive."""
        return cls.ACHIEVED if outcome.failure is None else cls(outcome.failure.value)

    @property
    def is_good(self) -> bool:
        return self in (CallOutcome.DONE, CallOutcome.ACHIEVED)

    @property
    def is_return(self) -> bool:
        """Whether a program decided to end so."""
        return self in (CallOutcome.DONE, CallOutcome.UNFINISHED)


class Ending(StrEnum):
    """How a run ended."""

    DONE = "done"
    UNFINISHED = "unfinished"  # nothing that the program knows helps
    STOPPED = "stopped"  # by a limit


class Attribution(StrEnum):
    """What a failure or a divergence is attributed to."""

    DECISION = "decision"
    PLANNER = "planner"
    GRASP = "grasp"
    PHYSICS = "physics"
    DISTURBANCE = "disturbance"
    START = "start"  # two traces that began in different states


class Execution(Struct, frozen=True, omit_defaults=True, kw_only=True):
    """How a primitive was carried out."""

    planning: Seconds = 0.0  # wall
    moving: Seconds = 0.0  # wall
    solver: str = ""
    planner: str = ""
    evidence: dict[str, Any] = {}  # what was measured, in the words of whoever did
    disturbances: tuple[str, ...] = ()


NOT_EXECUTED = Execution()


class DemonstratedCall(Struct, kw_only=True):
    """A call that a demonstration shows, with its frames [begin, end)."""

    name: str
    arguments: tuple[Argument, ...]
    scope: Frames
    done: bool
    children: list[DemonstratedCall] = []

    def walk(self) -> Iterator[DemonstratedCall]:
        """Yield the call and all below it, depth first."""
        yield self
        for child in self.children:
            yield from child.walk()


class ShownDemonstration(Struct, frozen=True, omit_defaults=True, kw_only=True):
    """The demonstration that the scopes of a trace are frames of."""

    file: str  # beside the trace
    frames: Count
    calls: DemonstratedCall | None = None  # None where the demonstration was made elsewhere


class Header(Struct, tag_field="event", tag="header", frozen=True, omit_defaults=True, kw_only=True):
    """What a trace says of itself; what is missing is unknown."""

    format: str
    version: int
    library: str = ""
    registry: str = ""  # hash of its programs and apis
    task: str = ""
    goal: tuple[Record, ...] = ()
    program: str = ""
    arguments: tuple[Argument, ...] = ()
    policy: PolicyKind | None = None
    model: str | None = None
    seed: int | None = None
    episode: int | None = None
    world: str | None = None
    arm: str | None = None  # None for the Panda
    disturbances: Disturbances | None = None
    objects: tuple[SceneObject, ...] = ()
    demonstration: ShownDemonstration | None = None
    sources: dict[str, str] = {}  # file name -> text of a library that decisions refer to


class End(Struct, tag_field="event", tag="end", frozen=True, omit_defaults=True, kw_only=True):
    """How a run ended, and what was judged of it."""

    ending: Ending
    reason: str = ""
    primitives: Count = 0
    success: bool | None = None  # None where nobody judged
    attributed_to: Attribution | None = None  # of a failure
    verdict: str = ""


@dataclass
class Call:
    """A call in a trace, with what came of it."""

    id: int
    parent: int  # ROOT for the task's own program
    kind: CallKind
    name: str
    arguments: tuple[Argument, ...]
    scope: Frames | None
    frame: int  # of the episode, when the call was made
    state: int  # the line of states that the decision was made in
    decision: Decision = NO_DECISION  # of its caller, to make this call
    end_frame: int | None = None
    end_state: int | None = None  # that a program decided to return in
    outcome: CallOutcome | None = None  # None where the trace was cut off
    ending: Decision | None = None  # of a program, to return
    execution: Execution = NOT_EXECUTED  # of a primitive

    @property
    def is_program(self) -> bool:
        return self.kind is CallKind.PROGRAM

    @property
    def went_well(self) -> bool:
        return self.outcome is not None and self.outcome.is_good


@dataclass(frozen=True)
class Motion:
    """What moved up to a frame of the episode, since the one before; one frame is a tenth of a second."""

    frame: int
    time: float  # [s] since the reset
    positions: Mapping[str, Vector]  # of what moved
    gripper: Vector
    closed: bool


@dataclass(repr=False)
class Trace:
    """A trace read back; a notebook shows its call tree."""

    header: Header
    calls: list[Call] = field(default_factory=list)
    states: Sequence[Observation] = ()
    motions: list[Motion] = field(default_factory=list)
    pictures: list[tuple[int, str]] = field(default_factory=list)  # frame, file beside the trace
    end: End | None = None  # None where the writer was cut off

    @cached_property
    def _offspring(self) -> list[list[int]]:
        """Numbers of the calls that each call made; those of the root come last."""
        found: list[list[int]] = [[] for _ in range(len(self.calls) + 1)]
        for call in self.calls:
            found[call.parent].append(call.id)
        return found

    def children(self, parent: int) -> list[Call]:
        """Return the calls that a call made, or the root calls for `ROOT`."""
        return [self.calls[number] for number in self._offspring[parent]]

    def ancestors(self, number: int) -> Iterator[Call]:
        """Yield the call, its caller, and so on to the root."""
        while number != ROOT:
            call = self.calls[number]
            yield call
            number = call.parent

    def events(self) -> Iterator[tuple[Call, bool]]:
        """Yield calls and returns in the order of execution: a call, and whether it returns."""
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
        return self.header.policy is PolicyKind.REPLAYED

    @property
    def is_learned(self) -> bool:
        """Whether a core decided, or answered."""
        return self.header.policy is PolicyKind.LEARNED or self.header.model is not None

    def to_dataframe(self) -> pandas.DataFrame:
        """Return a row for each call: see `outline.dataframe`. Needs pandas, of the extra `notebook`."""
        from ntp_dsl.traces.outline import dataframe

        return dataframe(self)

    def __repr__(self) -> str:
        ended = "cut off" if self.end is None else str(self.end.ending)
        return f"<Trace of {self.header.task or 'a run'}: {len(self.calls)} calls, {ended}>"

    def _repr_html_(self) -> str:
        from ntp_dsl.traces.outline import outline

        return f"<pre>{escape(outline(self))}</pre>"
