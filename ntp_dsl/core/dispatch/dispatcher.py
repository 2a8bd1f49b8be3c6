"""The interface of dispatchers."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

from ntp_dsl.core.perception.perceived import Believed
from ntp_dsl.policies.expert import NextCall, Return
from ntp_dsl.policies.protocol import Barred
from ntp_dsl.semantics.facts import Fact
from ntp_dsl.semantics.observation import Argument
from ntp_dsl.traces.decision import Decision


@dataclass(frozen=True)
class Situation:
    """A running program, the state that it finds, and the callees that it may not call (None: no return)."""

    program: str
    arguments: tuple[Argument, ...]
    state: Believed
    barred: Barred = frozenset()


@dataclass(frozen=True)
class Dispatched:
    """The next call of a program, or its return, with what a trace says of the decision."""

    answer: NextCall | Return
    decision: Decision
    achieved: float  # how probably all holds that the program is to achieve
    grounds: tuple[Fact, ...]  # facts that the decision rests on, as it has them
    others: tuple[tuple[NextCall | Return, float], ...] = ()  # the most probable first, none of them barred


class Dispatcher(Protocol):
    """Finds the next call of any declared program."""

    def dispatch(self, situations: Sequence[Situation]) -> list[Dispatched]:
        """Return for each situation the next call, never one of the barred callees, or a return."""
