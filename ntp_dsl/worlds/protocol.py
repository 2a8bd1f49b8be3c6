"""The interface of worlds: objects on a table, and primitives that change them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from enum import StrEnum
from functools import cached_property
from math import inf
from typing import Any, Protocol

from ntp_dsl.language.diagnostics.diagnostics import NtpError
from ntp_dsl.semantics.geometry import Quaternion, Vector, about_vertical
from ntp_dsl.semantics.observation import Argument, DeclaredFact, Observation, SceneObject

OUT_OF_THE_WAY: Vector = (0.0, 0.0, 1.0)  # above the robot's base [m]


@dataclass(frozen=True)
class Scene:
    """The objects of a scene and where they start. `table` and its like are objects that never move."""

    objects: tuple[SceneObject, ...]
    positions: Mapping[str, Vector]  # centres
    yaws: Mapping[str, float] = field(default_factory=dict)  # [rad]
    gripper: Vector | None = None  # where the tool starts; at home where None
    held: str | None = None  # in the hand at the start; only in the kinematic world
    facts: frozenset[DeclaredFact] = frozenset()  # of the state, that hold at the start

    @cached_property
    def by_name(self) -> Mapping[str, SceneObject]:
        return {obj.name: obj for obj in self.objects}

    @cached_property
    def orientations(self) -> Mapping[str, Quaternion]:
        """Return how objects are turned about the vertical at the start."""
        return {name: about_vertical(yaw) for name, yaw in self.yaws.items()}

    @property
    def lying(self) -> Mapping[str, SceneObject]:
        """Return each object as it lies: one that is turned has its extents exchanged."""
        return self.seen.by_name

    @cached_property
    def seen(self) -> Observation:
        """Return what is observed at the start, with an open hand that is out of the way."""
        return Observation(
            self.objects,
            self.positions,
            OUT_OF_THE_WAY,
            closed=False,
            orientations=self.orientations,
            facts=self.facts,
        )


class Failure(StrEnum):
    """Why a primitive failed. Every world answers with one of these."""

    NOT_READY = "not ready"  # a requirement of the api did not hold
    NO_IK = "no inverse kinematics"
    START_IN_COLLISION = "start in collision"
    GOAL_IN_COLLISION = "goal in collision"
    NO_PATH = "no path"
    GRASP_FAILED = "grasp failed"
    OBJECT_DROPPED = "object dropped"
    PLACE_FAILED = "place failed"
    MISSING_OBJECT = "missing object"
    TIME_OUT = "time-out"


LONGEST_LATENCY = 0.5  # of an observation [s]
NO_ATTEMPT = frozenset({Failure.NOT_READY, Failure.MISSING_OBJECT, Failure.OBJECT_DROPPED})


@dataclass(frozen=True)
class Outcome:
    """The outcome of a primitive: achieved, or the reason why not, with the evidence."""

    achieved: bool
    failure: Failure | None = None
    evidence: Mapping[str, Any] = field(default_factory=dict)
    planning_seconds: float = 0.0  # wall
    moving_seconds: float = 0.0  # wall
    solver: str = ""
    planner: str = ""
    disturbances: tuple[str, ...] = ()

    def __bool__(self) -> bool:
        return self.achieved

    @property
    def is_failed_attempt(self) -> bool:
        """Return whether it failed at what it was given: other reasons are in `NO_ATTEMPT`."""
        return not self.achieved and self.failure not in NO_ATTEMPT


ACHIEVED = Outcome(True)


@dataclass(frozen=True)
class Disturbances:
    """Deliberate disturbances, by seed: probabilities, and what is wrong with sensors, objects and hand."""

    slips: float = 0.0
    pushes: float = 0.0
    noise: float = 0.0  # standard deviation of each observation [m]
    clumsiness: float = 0.0  # motions and placements that miss; only in the kinematic world
    latency: float = 0.0  # of every observation [s]
    camera_offset: float = 0.0  # by which a camera is off, the same way in all of an episode [m]
    spread: float = 0.0  # of masses and friction about what the scene says, as a share; with an arm
    weak_grip: float = 0.0  # the share of the hand's force that is missing; with an arm

    @property
    def need_an_arm(self) -> bool:
        """Whether only a world with an arm has them."""
        return bool(self.spread or self.weak_grip)

    @property
    def misleads(self) -> bool:
        """Whether what is observed differs from what is true."""
        return bool(self.noise or self.latency or self.camera_offset)

    def __post_init__(self) -> None:
        """Raise `NtpError` for what is no probability, no share, and no finite length or time."""
        for name in ("slips", "pushes", "clumsiness"):
            if not 0 <= getattr(self, name) <= 1:
                raise NtpError(f"{name}: expected a probability, from 0 to 1; found {getattr(self, name)}")
        if not 0 <= self.noise < inf:
            raise NtpError(f"noise: expected a standard deviation in metres, found {self.noise}")
        if not 0 <= self.latency <= LONGEST_LATENCY:
            raise NtpError(f"latency: expected 0 to {LONGEST_LATENCY:g} seconds, found {self.latency}")
        if not 0 <= self.camera_offset < inf:
            raise NtpError(f"camera_offset: expected a distance in metres, found {self.camera_offset}")
        for name in ("spread", "weak_grip"):
            if not 0 <= getattr(self, name) < 1:
                raise NtpError(f"{name}: expected a share, from 0 to below 1; found {getattr(self, name)}")


UNDISTURBED = Disturbances()


class World(Protocol):
    """Objects on a table and an arm over them."""

    on_frame: Callable[[Observation], None] | None  # every 0.1 s of a primitive, and after it
    skills: dict[str, Callable[..., Outcome]]  # by name, what it can carry out
    starts_holding: bool  # whether a scene may start with an object in the hand
    disturbed: set[str]  # objects that a disturbance has moved since the reset
    facts: frozenset[DeclaredFact]  # of the state, that hold now: a part of what is observed

    def reset(self, scene: Scene, seed: int, disturbances: Disturbances = UNDISTURBED) -> None: ...

    def observe(self) -> Observation:
        """Return what a policy sees, observation noise included."""

    def truth(self) -> Observation:
        """Return the same without noise: for experts and success tests, never for a learned program."""

    def call(self, api: str, arguments: tuple[Argument, ...]) -> Outcome: ...

    def move_over(self, x: float, y: float) -> Outcome:
        """Move the held object, or else the hand, over a point of the table [m]; for skills in Python."""

    def settle(self, seconds: float) -> None:
        """Let time pass [s]."""

    def supported(self, item: str, support: str) -> bool:
        """Return whether `item` rests on `support` by contact, or lies in it."""

    @property
    def time(self) -> float:
        """Return the simulated time since the reset [s]."""
