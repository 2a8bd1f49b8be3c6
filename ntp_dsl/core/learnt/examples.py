"""The decisions of one program in traces: what it was called with, what it saw, and the call it made."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from ntp_dsl.language.diagnostics.diagnostics import NtpError
from ntp_dsl.language.registry import Program, Registry
from ntp_dsl.semantics.observation import Argument, Observation
from ntp_dsl.semantics.value_checks import types_of, unfit_call
from ntp_dsl.traces.trace import Trace


@dataclass(frozen=True)
class Example:
    """A decision of a program that was followed by a call."""

    trace: int  # the number of the trace that it is from
    arguments: tuple[Argument, ...]  # of the program
    seen: Observation
    callee: str
    given: tuple[Argument, ...]  # to the callee


def examples_in(registry: Registry, program: Program, traces: Sequence[Trace]) -> list[Example]:
    """Return the decisions of a program in traces, one for each of its calls.

    Raises `NtpError` where there are none, and where a call is none of those that are declared.
    """
    found = [each for number, trace in enumerate(traces) for each in _of(trace, number, program.name)]
    if not found:
        raise NtpError(
            f"no trace of an expert has a call of '{program.name}' that called something: record its task"
        )
    for each in found:
        _check(registry, program, each)
    return found


def _of(trace: Trace, number: int, program: str) -> Iterator[Example]:
    for caller in trace.calls:
        if caller.name == program and caller.is_program:
            for call in trace.children(caller.id):
                yield Example(number, caller.arguments, trace.states[call.state], call.name, call.arguments)


def _check(registry: Registry, program: Program, example: Example) -> None:
    types = types_of(registry, example.seen)
    if example.callee not in program.callees:
        wrong = f"'{program.name}' calls '{example.callee}', and declares {', '.join(program.callees)}"
    elif unfit := unfit_call(registry, program, example.arguments, types):
        wrong = f"'{program.name}' is called; {unfit}"
    elif unfit := unfit_call(registry, registry[example.callee], example.given, types):
        wrong = f"'{example.callee}' is called; {unfit}"
    else:
        return
    raise NtpError(f"the traces are of another declaration: in one of them {wrong}; record them anew")
