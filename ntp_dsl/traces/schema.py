"""The contents of a trace: calls in order of execution, the states they were decided in, and frames."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from enum import StrEnum
from typing import Any

from msgspec import Struct

from ntp_dsl.common.decoding import Count
from ntp_dsl.semantics.geometry import Vector
from ntp_dsl.semantics.observation import Argument, Record, SceneObject
from ntp_dsl.traces.decision import NO_DECISION, Decision, Dispatch, Frames, Probability, Seconds
from ntp_dsl.worlds.protocol import Disturbances, Failure, Outcome

FORMAT = "ntp-trace"
VERSION = 3
ROOT = -1
MAX_DEPTH = 200  # of calls in calls; the interpreter stops long before


class CallKind(StrEnum):
    """The kind of a callee."""

    PROGRAM = "program"
    API = "api"


class PolicyKind(StrEnum):
    """The kind of policy whose decisions a trace records."""

    SCRIPTED = "scripted"
    LEARNED = "learned"
    REPLAYED = "replayed"  # a policy's answers at every state of another trace
    DEMONSTRATION = "demonstration"
    CUSTOM = "custom"  # a user's own


class CallOutcome(StrEnum):
    """The outcome of a call."""

    DONE = "done"  # of programs, like the next two
    UNFINISHED = "unfinished"
    STOPPED = "stopped"
    ACHIEVED = "achieved"  # of primitives, like all that follow
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
    def is_success(self) -> bool:
        return self in (CallOutcome.DONE, CallOutcome.ACHIEVED)

    @property
    def is_return(self) -> bool:
        """Whether it is the outcome of a program's decision to return."""
        return self in (CallOutcome.DONE, CallOutcome.UNFINISHED)


class Ending(StrEnum):
    """How a run ended."""

    DONE = "done"
    UNFINISHED = "unfinished"  # no statement of the program helps: the goal cannot be achieved any more
    CIRCULAR = "circular"  # what helps comes round to the same states again and again
    STOPPED = "stopped"  # by a limit


class Attribution(StrEnum):
    """The cause that a failure or a divergence is attributed to."""

    DECISION = "decision"
    PLANNER = "planner"
    GRASP = "grasp"
    PHYSICS = "physics"
    DISTURBANCE = "disturbance"
    NOISE = "noise"  # a fact was seen wrongly, of two traces
    START = "start"  # two traces that began in different states


class Execution(Struct, frozen=True, omit_defaults=True, kw_only=True):
    """How a primitive was executed."""

    planning: Seconds = 0.0  # wall time
    moving: Seconds = 0.0  # wall time
    solver: str = ""
    planner: str = ""
    evidence: dict[str, Any] = {}  # measurements, under the names of the world that made them
    disturbances: tuple[str, ...] = ()
    unmet: tuple[str, ...] = ()  # what it is to achieve, and what did not hold although it reported success


NOT_EXECUTED = Execution()


class DemonstratedCall(Struct, kw_only=True):
    """A call that a demonstration shows, with its frames [begin, end) and the calls below it."""

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

    @property
    def depth(self) -> int:
        """Return how many calls are in one another, itself included."""
        depth, calls = 0, [self]
        while calls:
            depth, calls = depth + 1, [child for call in calls for child in call.children]
        return depth


class DemonstrationReference(Struct, frozen=True, omit_defaults=True, kw_only=True):
    """The demonstration that the scopes of a trace refer to."""

    file: str  # beside the trace
    frames: Count
    calls: DemonstratedCall | None = None  # None where the demonstration was not recorded with its calls
    noise: float = 0.0  # that was added to its positions, standard [m]
    by: str = ""  # a simulated person
    rate: float | None = None  # of a person's demonstration, frames a second


class Header(Struct, tag_field="event", tag="header", frozen=True, omit_defaults=True, kw_only=True):
    """The origin of a trace; missing fields are unknown."""

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
    training: str = ""  # with what the model was trained, where that is far less than usual
    dispatch: Dispatch | None = None  # of the one core
    seed: int | None = None
    episode: int | None = None
    world: str | None = None
    arm: str | None = None  # None for the Panda
    disturbances: Disturbances | None = None
    objects: tuple[SceneObject, ...] = ()
    demonstration: DemonstrationReference | None = None
    said: tuple[str, ...] = ()  # the sentences that told the program its lists
    understood: Probability = 1.0  # how probably they mean these lists
    sources: dict[str, str] = {}  # file name -> text of a library that decisions refer to


class End(Struct, tag_field="event", tag="end", frozen=True, omit_defaults=True, kw_only=True):
    """The end of a run, and how its result was judged."""

    ending: Ending
    reason: str = ""
    primitives: Count = 0
    confidence: Probability | None = None  # that what was shown is done, as the policy finds
    least: Probability | None = None  # of the decisions' probabilities
    success: bool | None = None  # None where it was not judged
    attributed_to: Attribution | None = None  # of a failure
    verdict: str = ""


@dataclass
class Call:
    """A call in a trace, with its outcome."""

    id: int
    parent: int  # ROOT for the task's own program
    kind: CallKind
    name: str
    arguments: tuple[Argument, ...]
    scope: Frames | None
    frame: int  # of the episode, when the call was made
    state: int  # number of the state that the decision was made in
    decision: Decision = NO_DECISION  # of its caller, to make this call
    end_frame: int | None = None
    end_state: int | None = None  # in which a program decided to return
    outcome: CallOutcome | None = None  # None where the trace was cut off
    return_decision: Decision | None = None  # of a program
    execution: Execution = NOT_EXECUTED  # of a primitive

    @property
    def is_program(self) -> bool:
        return self.kind is CallKind.PROGRAM

    @property
    def succeeded(self) -> bool:
        return self.outcome is not None and self.outcome.is_success


@dataclass(frozen=True)
class Motion:
    """The objects that moved between two frames of the episode; a frame is a tenth of a second."""

    frame: int
    time: float  # [s] since the reset
    positions: Mapping[str, Vector]  # of the objects that moved
    gripper: Vector
    closed: bool
