"""The interface of dispatchers."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

from ntp_dsl.core.perception.perceived import Believed
from ntp_dsl.policies.expert import NextCall, Return
from ntp_dsl.policies.protocol import Barred
from ntp_dsl.semantics.observation import Argument
from ntp_dsl.traces.decision import Decision


@dataclass(frozen=True)
class Dispatched:
    """The next call of a program, or its return, with what a trace says of the decision."""

    answer: NextCall | Return
    decision: Decision


class Dispatcher(Protocol):
    """Finds the next call of any declared program."""

    def dispatch(
        self, program: str, arguments: tuple[Argument, ...], state: Believed, barred: Barred
    ) -> Dispatched:
        """Return the next call, never one of the `barred` callees, or a return."""
