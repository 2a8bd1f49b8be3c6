"""What a call is in words: by its declaration's own wording, or by its name."""

from __future__ import annotations

from collections.abc import Sequence
from math import pi

from ntp_dsl.language.registry import Callable, Program, Registry
from ntp_dsl.semantics.observation import Argument, without_lists
from ntp_dsl.sentences.english import name_words
from ntp_dsl.sentences.forms import filled, sayable, spoken_by_name

SPOKEN = {"length": ("cm", 0.01), "angle": ("degrees", pi / 180), "time": ("s", 1.0), "mass": ("kg", 1.0)}


def narrated(registry: Registry, callee: Callable, arguments: Sequence[Argument]) -> str:
    """Return a call as a sentence: its docstring with the arguments in it, or words from its name."""
    parameters, values = sayable(registry, callee.parameters), without_lists(tuple(arguments))
    spoken = {each.name: said(value, each.type) for each, value in zip(parameters, values, strict=True)}
    worded = (filled(text, spoken) for text in (*callee.says, callee.docstring))
    return next(filter(None, worded), "") or " ".join(
        spoken_by_name(name_words(callee.name), [*spoken.values()])
    )


def said(value: str | float, type_name: str = "") -> str:
    """Return an object, a member or a number in words: `block_3` is "block 3"."""
    if isinstance(value, str):
        return value.replace("_", " ")
    unit, scale = SPOKEN.get(type_name, ("", 1.0))
    return f"{value / scale:.9g} {unit}".rstrip()


def example(registry: Registry, program: Program, callees: Sequence[str]) -> str:
    """Return how something that a program does can be said, with kinds in place of objects."""
    own = [name for name in program.callees if name in callees] or list(callees)
    if not own:
        return f"'{program.docstring}'"
    callee = registry[own[-1]]
    kinds = [f"<{' '.join(name_words(each.type))}>" for each in sayable(registry, callee.parameters)]
    return f"'{narrated(registry, callee, kinds)}'"
