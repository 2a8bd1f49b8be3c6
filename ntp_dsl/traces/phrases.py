"""Calls and traces in words, without what would command a terminal."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ntp_dsl.semantics.observation import Argument
from ntp_dsl.traces.schema import Call, Trace

if TYPE_CHECKING:
    from ntp_dsl.demonstrations.demonstration import Scope

BRIEF = 3  # elements of a list that are shown


def plain(text: object) -> str:
    told = str(text)
    return told if told.isprintable() else told.encode("unicode_escape").decode("ascii")


def shown(argument: Argument) -> str:
    """An argument, briefly: records without their types."""
    if isinstance(argument, tuple):
        more = [f"... {len(argument) - BRIEF} more"] if len(argument) > BRIEF else []
        return f"[{', '.join([*(shown(each) for each in argument[:BRIEF]), *more])}]"
    return f"{argument:g}" if isinstance(argument, float) else str(argument)


def in_words(call: Call) -> str:
    return plain(f"{call.name}({', '.join(map(shown, call.arguments))})")


def headline(trace: Trace) -> str:
    """What a trace says of itself, in a line."""
    told = ("library", "task", "policy", "world", "seed", "episode")
    facts = [f"{name} {trace.header[name]}" for name in told if trace.header.get(name) is not None]
    return plain(", ".join(facts)) or "a trace"


def scope_in_words(scope: Scope | None) -> str:
    return "no scope" if scope is None else f"frames {scope[0]}–{scope[1]}"
