"""Calls and traces in words, without what would command a terminal."""

from __future__ import annotations

from ntp_dsl.semantics.observation import Argument
from ntp_dsl.traces.decision import Frames
from ntp_dsl.traces.schema import Call, Trace

BRIEF = 3  # elements of a list that are shown


def plain(text: object) -> str:
    """Return a text in which nothing could command a terminal."""
    told = str(text)
    return told if told.isprintable() else told.encode("unicode_escape").decode("ascii")


def shown(argument: Argument) -> str:
    """Return an argument, briefly: records without their types."""
    if isinstance(argument, tuple):
        more = [f"... {len(argument) - BRIEF} more"] if len(argument) > BRIEF else []
        return f"[{', '.join([*(shown(each) for each in argument[:BRIEF]), *more])}]"
    return f"{argument:g}" if isinstance(argument, float) else str(argument)


def in_words(call: Call) -> str:
    """Return a call with its arguments."""
    return called(call.name, call.arguments)


def called(name: str, arguments: tuple[Argument, ...]) -> str:
    """Return a callee with its arguments."""
    return plain(f"{name}({', '.join(map(shown, arguments))})")


def headline(trace: Trace) -> str:
    """Return what a trace says of itself, in a line."""
    header = trace.header
    told = {
        "library": header.library or None,
        "task": header.task or None,
        "policy": header.policy,
        "world": header.world,
        "seed": header.seed,
        "episode": header.episode,
    }
    facts = [f"{name} {value}" for name, value in told.items() if value is not None]
    return plain(", ".join(facts)) or "a trace"


def scope_in_words(scope: Frames | None) -> str:
    """Return the frames of a scope."""
    return "no scope" if scope is None else f"frames {scope[0]}–{scope[1]}"
