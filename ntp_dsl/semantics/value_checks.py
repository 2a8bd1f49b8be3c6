"""Checks of values against declarations: objects of a type, members, records, numbers in their ranges."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from itertools import islice
from typing import Any

import numpy as np

from ntp_dsl.language.diagnostics.diagnostics import NtpError
from ntp_dsl.language.diagnostics.spelling import nearest
from ntp_dsl.language.names.signatures import with_article
from ntp_dsl.language.registry import Api, Callable, Parameter, Registry
from ntp_dsl.language.syntax.nodes import NOWHERE, Span, TypeName
from ntp_dsl.semantics.observation import Argument, Observation, Record

SLACK = 1e-6  # by which a calculated number may miss the end of a range [SI]
Types = Mapping[str, str]  # of the objects of a scene and of constants


class OutOfRange(NtpError):
    """A number is outside of its parameter's range; `span` is the call's place, if known."""

    def __init__(self, message: str, span: Span) -> None:
        self.message, self.span = message, span
        super().__init__(f"{span}: {message}" if span.path else message)


def plain(value: Any) -> Any:
    """Return the value with numpy scalars as Python numbers and lists as tuples."""
    if isinstance(value, list | tuple) and type(value) in (list, tuple):
        return tuple(map(plain, value))
    return value.item() if isinstance(value, np.generic) else value


def types_of(registry: Registry, observation: Observation) -> Types:
    """Return the type of everything that arguments may refer to, lost objects included."""
    return dict(registry.constants) | {obj.name: obj.type for obj in observation.objects}


def misfit(registry: Registry, parameter: Parameter, value: object, types: Types) -> str:
    """Return what was expected instead of the value, or an empty string; see `strays` for ranges."""
    wanted = with_article(TypeName(parameter.type, parameter.is_list))
    if parameter.is_list:
        return "" if isinstance(value, tuple) else wanted
    if parameter.type in registry.records:
        return "" if isinstance(value, Record) and value.type == parameter.type else wanted
    if parameter.type in registry.enums:
        members = registry.enums[parameter.type]
        return "" if isinstance(value, str) and value in members else " or ".join(members)
    if parameter.type not in registry.parents:
        return "" if isinstance(value, int | float) and not isinstance(value, bool) else "a number"
    if not isinstance(value, str) or value not in types:
        return "the name of an object in the scene"
    if registry.is_a(types[value], parameter.type):
        return ""
    return f"{wanted}, and '{value}' is {with_article(TypeName(types[value]))}"


def unfit_call(registry: Registry, row: Callable, arguments: tuple[Argument, ...], types: Types) -> str:
    """Return what is wrong with a call that a function in Python makes, or an empty string."""
    if len(row.parameters) != len(arguments):
        return f"it is declared as {row.name}({', '.join(each.name for each in row.parameters)})"
    for parameter, value in zip(row.parameters, arguments, strict=True):
        if expected := misfit(registry, parameter, value, types):
            return f"'{parameter.name}: {parameter.type}' is {value!r}; expected {expected}"
    return ""


def strays(parameter: Parameter, value: object) -> str:
    """Return the range that a number is outside of, or an empty string."""
    if parameter.low is None or parameter.high is None or not isinstance(value, int | float):
        return ""
    within = parameter.low - SLACK <= value <= parameter.high + SLACK
    return "" if within else f"{parameter.low:g} .. {parameter.high:g}"


def out_of_range(api: Api, arguments: tuple[Argument, ...]) -> list[str]:
    """Return the numbers outside of their ranges."""
    given = zip(api.parameters, arguments, strict=True)
    return [f"{parameter.name} = {value}" for parameter, value in given if strays(parameter, value)]


def check_ranges(row: Callable, arguments: tuple[Argument, ...], span: Span = NOWHERE) -> None:
    """Raise `OutOfRange` for the first number outside of its range.

    Args:
        span: of the statement that calls it.
    """
    for parameter, value in zip(row.parameters, arguments, strict=True):
        if limits := strays(parameter, value):
            raise OutOfRange(
                f"'{row.name}' is called with {parameter.name} = {value:g}, and takes {limits} "
                f"[SI units]; draw or calculate a number within, or declare a wider range at {row.span}",
                span,
            )


def guess(name: str, known: Iterable[str]) -> str:
    """Return the end of a message about an unknown name: the likely name, or the known ones."""
    known = sorted(set(known))
    meant = nearest(name, known)
    if meant:
        return f"; did you mean '{meant}'?"
    more = ", ..." if len(known) > 12 else ""
    return f"; there is: {', '.join(islice(known, 12))}{more}" if known else ""
