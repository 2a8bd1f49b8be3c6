"""Calls and traces as text, with control characters escaped."""

from __future__ import annotations

from pathlib import PurePath

from ntp_dsl.common.text import printable
from ntp_dsl.semantics.observation import Argument
from ntp_dsl.traces.decision import Asked, Doubt, Frames, Option
from ntp_dsl.traces.schema import Call, Header
from ntp_dsl.worlds.protocol import UNDISTURBED

MAX_LIST_ITEMS = 3  # of a list in a text


def format_argument(argument: Argument) -> str:
    """Return an argument as short text: records without their types, long lists cut."""
    if isinstance(argument, tuple):
        more = [f"... {len(argument) - MAX_LIST_ITEMS} more"] if len(argument) > MAX_LIST_ITEMS else []
        return f"[{', '.join([*(format_argument(each) for each in argument[:MAX_LIST_ITEMS]), *more])}]"
    return f"{argument:g}" if isinstance(argument, float) else str(argument)


def format_call(call: Call) -> str:
    """Return a call as text."""
    return format_invocation(call.name, call.arguments)


def format_invocation(name: str, arguments: tuple[Argument, ...]) -> str:
    """Return a callee with its arguments as text."""
    return printable(f"{name}({', '.join(map(format_argument, arguments))})")


def format_measurement(name: str, value: object) -> str:
    """Return a measurement of the world as text, its numbers to three digits."""
    return printable(f"{name.replace('_', ' ')}: {_shortly(value)}")


def _shortly(value: object) -> str:
    if isinstance(value, float):
        return f"{value:.3g}"
    if isinstance(value, list | tuple):
        return f"({', '.join(map(_shortly, value))})"
    return str(value)


def format_doubt(doubt: Doubt) -> str:
    """Return as text which element of a list may be which, and what somebody answered."""
    texts = [f"{format_argument(element)} {chance:.0%}" for element, chance in doubt.offered]
    answer = f"; answered {format_argument(doubt.answer)}" if doubt.answer is not None else ""
    return printable(f"element {doubt.number + 1} of '{doubt.parameter}': {' or '.join(texts)}{answer}")


def format_asked(asked: Asked) -> str:
    """Return as text what a program might do, and what somebody said that it was to do."""
    texts = [f"{format_option(each)} {each.probability:.0%}" for each in asked.options]
    return printable(f"{' or '.join(texts)}; answered {format_option(asked.taken)}")


def format_option(option: Option) -> str:
    """Return what a program may do as text."""
    return "be done" if option.callee is None else format_invocation(option.callee, option.arguments)


def headline(header: Header) -> str:
    """Return the origin of a trace in one line."""
    origin = {
        "library": header.library or None,
        "task": header.task or None,
        "policy": header.policy,
        "world": header.world,
        "seed": header.seed,
        "episode": header.episode,
    }
    facts = [f"{name} {value}" for name, value in origin.items() if value is not None]
    return printable(", ".join(filter(None, [*facts, conditions(header)]))) or "a trace"


def conditions(header: Header) -> str:
    """Return what a run was made difficult by, and the checkpoint that decided; empty without either."""
    made = header.disturbances or UNDISTURBED
    shown = header.demonstration.noise if header.demonstration else 0.0
    parts = {
        "model": "/".join(PurePath(header.model).parts[-2:]) if header.model else None,
        "trained with": header.training or None,
        "slips": made.slips or None,
        "pushes": made.pushes or None,
        "clumsiness": made.clumsiness or None,
        "noise": f"{1000 * made.noise:g} mm" if made.noise else None,
        "latency": f"{1000 * made.latency:g} ms" if made.latency else None,
        "camera off by": f"{1000 * made.camera_offset:g} mm" if made.camera_offset else None,
        "masses and friction": f"within {100 * made.spread:g} %" if made.spread else None,
        "grip weaker by": f"{100 * made.weak_grip:g} %" if made.weak_grip else None,
        "noise of the demonstration": f"{1000 * shown:g} mm" if shown else None,
    }
    return ", ".join(f"{name} {value}" for name, value in parts.items() if value is not None)


def format_scope(scope: Frames | None) -> str:
    """Return a scope as text."""
    return "no scope" if scope is None else f"frames {scope[0]}–{scope[1]}"
