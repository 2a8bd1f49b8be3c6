"""The lines of a trace as they are written and read: one type for each `event`."""

from __future__ import annotations

from typing import Annotated

from msgspec import Meta, Struct

from ntp_dsl.common.decoding import MAX_COUNT, Count
from ntp_dsl.semantics.geometry import Quaternion, Vector
from ntp_dsl.semantics.observation import Argument, DeclaredFact, Observation, SceneObject
from ntp_dsl.traces.decision import NO_DECISION, Decision, Frames, Seconds
from ntp_dsl.traces.schema import NOT_EXECUTED, CallKind, CallOutcome, End, Execution, Header

DIGITS = 5  # of positions [m]


class StateEvent(Struct, tag_field="event", tag="state", frozen=True, omit_defaults=True):
    """An observation that decisions are based on."""

    id: Count
    positions: dict[str, Vector]  # world frame [m]
    gripper: Vector
    closed: bool
    orientations: dict[str, Quaternion] = {}
    deviations: dict[str, float] = {}  # [m]
    facts: tuple[DeclaredFact, ...] = ()
    unreachable: tuple[str, ...] = ()

    @classmethod
    def of(cls, number: int, observation: Observation) -> StateEvent:
        """Return an observation as a line, with positions rounded to 0.01 mm and quaternions to 1e-4."""
        return cls(
            number,
            {name: _rounded(place) for name, place in observation.positions.items()},
            _rounded(observation.gripper),
            bool(observation.closed),
            {name: _rounded_quaternion(turn) for name, turn in observation.orientations.items()},
            {name: round(float(sigma), DIGITS) for name, sigma in observation.deviations.items()},
            tuple(sorted(observation.facts)),
            tuple(sorted(observation.unreachable)),
        )

    def observation(self, objects: tuple[SceneObject, ...]) -> Observation:
        """Return the observation of these objects."""
        return Observation(
            objects,
            self.positions,
            self.gripper,
            self.closed,
            frozenset(self.unreachable),
            self.orientations,
            self.deviations,
            frozenset(self.facts),
        )


class CallEvent(Struct, tag_field="event", tag="call", frozen=True, omit_defaults=True):
    """The beginning of a call."""

    id: Count
    parent: Annotated[int, Meta(ge=-1, le=MAX_COUNT)]
    kind: CallKind
    name: str
    arguments: tuple[Argument, ...]
    frame: Count
    state: Count
    scope: Frames | None = None
    decision: Decision = NO_DECISION


class ReturnEvent(Struct, tag_field="event", tag="return", frozen=True, omit_defaults=True):
    """The end of the innermost open call."""

    id: Count
    outcome: CallOutcome
    frame: Count
    state: Count | None = None
    decision: Decision | None = None
    execution: Execution = NOT_EXECUTED


class FrameEvent(Struct, tag_field="event", tag="frame", frozen=True):
    """A frame of the motion; there are ten per second."""

    id: Count
    time: Seconds
    moved: dict[str, Vector]
    gripper: Vector
    closed: bool


class PictureEvent(Struct, tag_field="event", tag="picture", frozen=True):
    """A camera's picture of a frame."""

    frame: Count
    file: str


Event = Header | StateEvent | CallEvent | ReturnEvent | FrameEvent | PictureEvent | End


def _rounded(point: Vector) -> Vector:
    x, y, z = point
    return round(float(x), DIGITS), round(float(y), DIGITS), round(float(z), DIGITS)


def _rounded_quaternion(quaternion: Quaternion) -> Quaternion:
    x, y, z, w = quaternion
    return round(float(x), 4), round(float(y), 4), round(float(z), 4), round(float(w), 4)
