"""What decides: a policy is asked about one running program at a time."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Protocol

from ntp_dsl.demonstrations.demonstration import Scope
from ntp_dsl.semantics.observation import Argument, Observation
from ntp_dsl.traces.decision import NO_DECISION, Decision
from ntp_dsl.worlds.protocol import World


@dataclass(frozen=True)
class Frame:
    """A running program: what its caller gave it. `matched` is the policy's own."""

    program: str
    arguments: tuple[Argument, ...]
    scope: Scope | None
    matched: Any = None


@dataclass(frozen=True)
class Choice:
    """What a policy decided: a call, or a return where `callee` is None."""

    callee: str | None
    arguments: tuple[Argument, ...] = ()
    scope: Scope | None = None
    done: bool = True  # of a return; a learned program cannot tell done from unfinished, so it says done
    matched: Any = None
    decision: Decision = NO_DECISION  # probabilities, alternatives and source: for the trace
    seen: Observation | None = None  # what it was decided by


Barred = frozenset[str | None]


class Policy(Protocol):
    """Decides for one running program at a time, from what it is given and what it can see."""

    def root(self, program: str, arguments: tuple[Argument, ...]) -> Frame: ...

    def decide(self, frame: Frame, world: World, barred: Barred = frozenset()) -> Choice:
        """The next call, or a return; not one of the `barred` callees, None among them for a return."""
