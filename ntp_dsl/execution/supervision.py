"""Whoever supervises a running program: waits before a decision is carried out, or forces an outcome."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

from ntp_dsl.language.diagnostics.diagnostics import NtpError
from ntp_dsl.language.diagnostics.spelling import nearest
from ntp_dsl.language.registry import Registry
from ntp_dsl.policies.protocol import Choice, Frame
from ntp_dsl.semantics.observation import Argument
from ntp_dsl.traces.phrases import format_invocation
from ntp_dsl.worlds.protocol import ACHIEVED, Failure, Outcome

FORCED = "forced"  # as a disturbance of a trace
OUTCOMES = {"achieved": ACHIEVED, **{each.name.lower(): Outcome(False, each) for each in Failure}}


class Supervisor(Protocol):
    """Someone who may stop a program before a decision is carried out, and who may force an outcome."""

    def before(self, depth: int, frame: Frame, choice: Choice) -> None:
        """Return when a decision may be carried out.

        Args:
            depth: number of programs that are running.
            frame: of the program that decided.
            choice: its decision, with what it rests on where a trace is written.
        """

    def outcome(self, callee: str, arguments: tuple[Argument, ...]) -> Outcome | None:
        """Return what a primitive comes to without being carried out; None to carry it out."""


@dataclass(frozen=True)
class Injection:
    """An outcome that is forced on a primitive, once."""

    call: str  # `grasp`, or with arguments, without spaces: `grasp(block_3)`
    outcome: Outcome

    @classmethod
    def parse(cls, text: str, registry: Registry) -> Injection:
        """Return what `grasp(block_3)=object_dropped` says. Raises `NtpError` for anything else."""
        call, equals, name = (part.strip() for part in text.rpartition("="))
        outcome = OUTCOMES.get(name)
        if not equals or outcome is None:
            hint = f"; did you mean '{near}'?" if equals and (near := nearest(name, OUTCOMES)) else ""
            expected = "--inject: expected CALL=OUTCOME, such as grasp(block_3)=object_dropped"
            raise NtpError(f"{expected}, found '{text}'{hint}; outcomes are {', '.join(OUTCOMES)}")
        api = call.partition("(")[0]
        if api not in registry.apis:
            hint = f"; did you mean '{near}'?" if (near := nearest(api, registry.apis)) else ""
            raise NtpError(f"--inject: '{api}' is no api of library '{registry.name}'{hint}")
        return cls(call.replace(" ", ""), outcome)


class Injections:
    """Forces each outcome on the first primitive that it fits."""

    def __init__(self, injections: Sequence[Injection]) -> None:
        self.waiting = [*injections]

    def before(self, depth: int, frame: Frame, choice: Choice) -> None:
        """Let everything be carried out."""

    def outcome(self, callee: str, arguments: tuple[Argument, ...]) -> Outcome | None:
        """Return the forced outcome of a primitive, marked as such, or None."""
        whole = format_invocation(callee, arguments).replace(" ", "")
        for each in self.waiting:
            if each.call in (callee, whole):
                self.waiting.remove(each)
                return Outcome(each.outcome.achieved, each.outcome.failure, disturbances=(FORCED,))
        return None
