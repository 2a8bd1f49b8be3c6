"""The decisions of one program in traces: what it was called with, what it saw, and the call it made."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from ntp_dsl.semantics.observation import Argument, Observation
from ntp_dsl.traces.trace import Trace


@dataclass(frozen=True)
class Example:
    """A decision of a program that was followed by a call."""

    arguments: tuple[Argument, ...]  # of the program
    seen: Observation
    callee: str
    given: tuple[Argument, ...]  # to the callee


def examples_in(traces: Sequence[Trace], program: str) -> list[Example]:
    """Return the decisions of a program in traces, one for each of its calls."""
    return [each for trace in traces for each in _of(trace, program)]


def _of(trace: Trace, program: str) -> Iterator[Example]:
    for caller in trace.calls:
        if caller.name == program and caller.is_program:
            for call in trace.children(caller.id):
                yield Example(caller.arguments, trace.states[call.state], call.name, call.arguments)
