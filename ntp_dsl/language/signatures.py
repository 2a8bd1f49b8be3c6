"""Parameters and what fits them: types, units and ranges, and the places of names within a text."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from ntp_dsl.language import syntax
from ntp_dsl.language.diagnostics import unknown
from ntp_dsl.language.names import NUMBER_TYPES, UNITS, Table, check_type
from ntp_dsl.language.syntax import Span, TypeName

Names = Mapping[str, TypeName]  # parameters and loop variables in sight


def head(span: Span, name: str) -> Span:
    """The name with which a stretch of text begins."""
    return Span(span.path, span.line, span.column, span.line, span.column + len(name))


def tail(span: Span, name: str) -> Span:
    """The name with which a stretch of text ends."""
    return Span(
        span.path, span.end_line, span.end_column - len(name), span.end_line, span.end_column
    )


def phrase(type: TypeName) -> str:
    """A type as a reader would say it."""
    text = f"list[{type.name}]" if type.is_list else type.name
    return f"{'an' if text[:1].lower() in 'aeiou' else 'a'} {text}"


def si(number: syntax.Number | None) -> float | None:
    """The number in SI units."""
    if number is None:
        return None
    return number.value * UNITS.get(number.unit, ("", 1.0))[1]


def fits(table: Table, actual: TypeName, expected: TypeName) -> bool:
    """Whether a value of one type may stand where the other is declared."""
    if not actual.name or not expected.name or expected.name not in table.type_names():
        return True
    if actual.is_list != expected.is_list:
        return False
    if actual.name in NUMBER_TYPES and expected.name in NUMBER_TYPES:
        return actual.name == expected.name or "number" in (actual.name, expected.name)
    return table.is_a(actual.name, expected.name)


def measure(
    table: Table, number: syntax.Number, expected: TypeName | None = None
) -> TypeName | None:
    """What the number measures; without a unit, whatever number is expected, in SI."""
    if not number.unit:
        fits = expected is not None and expected.name in NUMBER_TYPES
        return expected if fits else TypeName("number")
    if number.unit in UNITS:
        return TypeName(UNITS[number.unit][0])
    span = tail(number.span, number.unit)
    table.mistakes.append(unknown("E107", "there is no unit", number.unit, span, UNITS))
    return None


def check_parameters(table: Table, parameters: Sequence[syntax.Parameter]) -> Names:
    """The names that a signature declares, each once and of a type that exists."""
    names: dict[str, TypeName] = {}
    for parameter in parameters:
        if parameter.name in names:
            message = f"two parameters are called '{parameter.name}'"
            table.report("E305", message, parameter.span)
        known = check_type(table, parameter.type)
        names[parameter.name] = parameter.type if known else TypeName("")
        if known:
            _check_range(table, parameter)
    return names


def _check_range(table: Table, parameter: syntax.Parameter) -> None:
    if parameter.low is None or parameter.high is None:
        return
    if parameter.type.name not in NUMBER_TYPES or parameter.type.is_list:
        message = f"only a number has a range, and '{parameter.name}' is {phrase(parameter.type)}"
        table.report("E204", message, parameter.low.span)
        return
    for bound in (parameter.low, parameter.high):
        found = measure(table, bound, parameter.type)
        if found is not None and not fits(table, found, parameter.type):
            message = f"'{parameter.name}' is {phrase(parameter.type)}, and this {phrase(found)}"
            table.report("E204", message, bound.span)
    low, high = si(parameter.low), si(parameter.high)
    if low is not None and high is not None and low > high:
        table.report("E203", "this range is empty: it ends below its start", parameter.low.span)
