"""Whoever supervises a running program: waits before a decision is carried out, or forces an outcome."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Protocol

from ntp_dsl.language.diagnostics.diagnostics import NtpError
from ntp_dsl.language.diagnostics.spelling import nearest
from ntp_dsl.language.registry import Callable, Registry
from ntp_dsl.policies.protocol import Choice, Frame
from ntp_dsl.semantics.observation import Argument
from ntp_dsl.traces.phrases import format_argument
from ntp_dsl.worlds.protocol import ACHIEVED, Failure, Outcome

FORCED = "forced"  # as a disturbance of a trace
OUTCOMES = {"achieved": ACHIEVED, **{each.name.lower(): Outcome(False, each) for each in Failure}}
CALL = re.compile(r"(\w+)(?:\((.*)\))?")
COMMA = re.compile(r",(?![^\[(]*[\])])")  # outside of brackets


class Supervisor(Protocol):
    """Someone who may stop a program before a decision is carried out, and who may force an outcome."""

    def before(self, depth: int, frame: Frame, choice: Choice) -> None:
        """Return when a decision may be carried out.

        Args:
            depth: number of programs that are running.
            frame: of the program that decided.
            choice: its decision, with what it rests on.
        """

    def outcome(self, callee: str, arguments: tuple[Argument, ...]) -> Outcome | None:
        """Return what a primitive comes to without being carried out; None to carry it out."""


@dataclass(frozen=True)
class CallPattern:
    """A callee, with its arguments or with any."""

    callee: str
    arguments: tuple[str, ...] | None = None  # as text, without spaces; None for any

    @classmethod
    def parse(cls, text: str, known: Mapping[str, Callable]) -> CallPattern | None:
        """Return what `grasp` or `grasp(block_3)` means; None for what is neither, or not known.

        Raises `NtpError` for a wrong number of arguments.
        """
        found = CALL.fullmatch(text.strip())
        if found is None or found[1] not in known:
            return None
        if found[2] is None:
            return cls(found[1])
        given = found[2].replace(" ", "")
        arguments = tuple(COMMA.split(given)) if given else ()
        parameters = known[found[1]].parameters
        if len(arguments) != len(parameters):
            names = ", ".join(each.name for each in parameters)
            raise NtpError(f"'{text}': {found[1]} takes ({names}), found {len(arguments)} arguments")
        return cls(found[1], arguments)

    def matches(self, callee: str, arguments: tuple[Argument, ...]) -> bool:
        """Return whether a call is meant."""
        if callee != self.callee:
            return False
        return self.arguments is None or self.arguments == tuple(map(_plain, arguments))

    def __str__(self) -> str:
        return self.callee if self.arguments is None else f"{self.callee}({', '.join(self.arguments)})"


def _plain(argument: Argument) -> str:
    return format_argument(argument).replace(" ", "")


@dataclass(frozen=True)
class Injection:
    """An outcome that is forced on a primitive, once."""

    call: CallPattern
    outcome: Outcome

    @classmethod
    def parse(cls, text: str, registry: Registry) -> Injection:
        """Return what `grasp(block_3)=object_dropped` says. Raises `NtpError` for anything else."""
        given, equals, name = (part.strip() for part in text.rpartition("="))
        outcome = OUTCOMES.get(name)
        if not equals or outcome is None:
            hint = f"; did you mean '{near}'?" if equals and (near := nearest(name, OUTCOMES)) else ""
            expected = "--inject: expected CALL=OUTCOME, such as grasp(block_3)=object_dropped"
            raise NtpError(f"{expected}, found '{text}'{hint}; outcomes are {', '.join(OUTCOMES)}")
        call = CallPattern.parse(given, registry.apis)
        if call is None:
            api = given.partition("(")[0]
            hint = f"; did you mean '{near}'?" if (near := nearest(api, registry.apis)) else ""
            raise NtpError(f"--inject: '{given}' is no call of an api of library '{registry.name}'{hint}")
        return cls(call, outcome)


class Injections:
    """Forces each outcome on the first primitive that it fits."""

    def __init__(self, injections: Sequence[Injection]) -> None:
        self.waiting = [*injections]

    def outcome(self, callee: str, arguments: tuple[Argument, ...]) -> Outcome | None:
        """Return the forced outcome of a primitive, marked as such, or None."""
        for each in self.waiting:
            if each.call.matches(callee, arguments):
                self.waiting.remove(each)
                return Outcome(each.outcome.achieved, each.outcome.failure, disturbances=(FORCED,))
        return None
