"""The interface of policies, which decide for one running program at a time."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Protocol, runtime_checkable

from ntp_dsl.demonstrations.demonstration import Scope
from ntp_dsl.semantics.facts import Fact
from ntp_dsl.semantics.observation import Argument, Observation
from ntp_dsl.traces.decision import NO_DECISION, Decision
from ntp_dsl.worlds.protocol import World


@dataclass(frozen=True)
class Frame:
    """A running program with its caller's arguments and scope. `matched` belongs to the policy."""

    program: str
    arguments: tuple[Argument, ...]
    scope: Scope | None
    matched: Any = None


@dataclass(frozen=True)
class Choice:
    """A policy's decision: a call, or a return where `callee` is None."""

    callee: str | None
    arguments: tuple[Argument, ...] = ()
    scope: Scope | None = None
    done: bool = True  # of a return; True for learned programs, which cannot tell done from unfinished
    matched: Any = None
    decision: Decision = NO_DECISION  # probabilities, alternatives and source: for the trace
    seen: Observation | None = None  # the observation behind the decision
    waited: float = 0.0  # for somebody's answer [s]
    grounds: tuple[Fact, ...] = ()  # the facts of the decision, whose truth a trace may tell


Barred = frozenset[str | None]


@runtime_checkable
class Tracking(Protocol):
    """A policy that estimates states from its observations; what a trace keeps is such an estimate."""

    def choose(self, frame: Frame, seen: Observation, barred: Barred) -> Choice:
        """Return the next call, or a return, in an estimated state."""


class Policy(Protocol):
    """Decides for one running program at a time, from its frame and the world's observation."""

    def root(self, program: str, arguments: tuple[Argument, ...]) -> Frame: ...

    def decide(self, frame: Frame, world: World, barred: Barred = frozenset()) -> Choice:
        """Return the next call, or a return; never one of the `barred` callees (None bars a return)."""
