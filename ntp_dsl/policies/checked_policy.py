"""A policy whose decisions are checked when they are made: a trace with a wrong one could not be read."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from msgspec import convert, to_builtins

from ntp_dsl.common.decoding import Unreadable, decoding
from ntp_dsl.language.diagnostics.diagnostics import NtpError
from ntp_dsl.policies.protocol import Barred, Choice, Frame, Policy
from ntp_dsl.semantics.observation import Argument
from ntp_dsl.traces.decision import Decision, Frames
from ntp_dsl.traces.schema import PolicyKind
from ntp_dsl.worlds.protocol import World


@dataclass
class CheckedPolicy:
    """Another policy. Raises `NtpError` for a scope or a decision of it that no trace may have."""

    policy: Policy

    def root(self, program: str, arguments: tuple[Argument, ...]) -> Frame:
        frame = self.policy.root(program, arguments)
        _check_type("root", frame, Frame)
        _check_scope("root", frame.scope)
        return frame

    def decide(self, frame: Frame, world: World, barred: Barred = frozenset()) -> Choice:
        choice = self.policy.decide(frame, world, barred)
        _check_type("decide", choice, Choice)
        _check_scope("decide", choice.scope)
        _check_fits("decide", "decision", choice.decision, Decision)
        return choice


def kind_of(policy: Policy) -> PolicyKind:
    """Return what a trace calls a policy. Raises `NtpError` for what is no policy or of no such kind."""
    if not (hasattr(policy, "root") and hasattr(policy, "decide")):
        raise NtpError(f"expected a policy, as learned_policy gives; found {policy!r}")
    kind = getattr(policy, "kind", PolicyKind.CUSTOM)
    if kind not in list(PolicyKind):
        known = ", ".join(PolicyKind)
        raise NtpError(f"expected a policy's kind to be one of {known}; found {kind!r}: omit it for custom")
    return PolicyKind(kind)


def _check_type(method: str, answer: object, expected: type) -> None:
    if not isinstance(answer, expected):
        raise NtpError(f"expected a {expected.__name__} from the policy's {method}; found {answer!r}")


def _check_scope(method: str, scope: Any) -> None:
    _check_fits(method, "scope", scope, Frames | None)
    if scope is not None and scope[0] > scope[1]:
        raise NtpError(
            f"expected a scope (begin, end) from the policy's {method}, begin first; found {scope}"
        )


def _check_fits(method: str, what: str, value: Any, expected: Any) -> None:
    try:
        with decoding():
            convert(to_builtins(value), expected)
    except Unreadable as error:
        raise NtpError(f"the policy's {method} gave a {what} that no trace may have: {error}") from error
