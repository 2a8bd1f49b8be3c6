"""Parameters and what fits them: types, units and ranges, and the places of names in a text."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

from ntp_dsl.language.diagnostics.checked import Checked
from ntp_dsl.language.diagnostics.diagnostics import Diagnostic, Edit, Fix
from ntp_dsl.language.names.symbol_table import NUMBER_TYPES, UNITS, SymbolTable, check_type
from ntp_dsl.language.syntax import nodes
from ntp_dsl.language.syntax.foreign_units import AMBIGUOUS, PRODUCTS, in_our_units
from ntp_dsl.language.syntax.formatter import format_expression
from ntp_dsl.language.syntax.nodes import Span, TypeName

Names = Mapping[str, TypeName]  # parameters and loop variables in scope


def leading_span(span: Span, name: str) -> Span:
    """Return the span of the name with which a stretch of text begins."""
    return Span(span.path, span.line, span.column, span.line, span.column + len(name))


def trailing_span(span: Span, name: str) -> Span:
    """Return the span of the name with which a stretch of text ends."""
    return Span(span.path, span.end_line, span.end_column - len(name), span.end_line, span.end_column)


def with_article(type: TypeName) -> str:
    """Return the type as a message names it: `a Block`, `an Object`, `a list[Placement]`."""
    text = f"list[{type.name}]" if type.is_list else type.name
    return f"{'an' if text[:1].lower() in 'aeiou' else 'a'} {text}"


def counted(number: int, noun: str) -> str:
    """Return `no argument`, `1 argument`, `2 arguments`."""
    return f"{number or 'no'} {noun}{'s' * (number > 1)}"


def are_given(number: int) -> str:
    """Return `none is given`, `1 is given`, `2 are given`."""
    return f"{number or 'none'} {'are' if number > 1 else 'is'} given"


def si(number: nodes.Number | None) -> float | None:
    """Return the number in SI units; None where there is no such unit."""
    if number is None or number.unit not in ("", *UNITS):
        return None
    return number.value * UNITS.get(number.unit, ("", 1.0))[1]


def fits(table: SymbolTable, actual: TypeName, expected: TypeName) -> bool:
    """Return whether a value of one type may be given where the other is declared."""
    if not actual.name or not expected.name or expected.name not in table.type_names():
        return True
    if actual.is_list != expected.is_list:
        return False
    if actual.name in NUMBER_TYPES and expected.name in NUMBER_TYPES:
        return actual.name == expected.name or "number" in (actual.name, expected.name)
    return table.is_a(actual.name, expected.name)


def measure(number: nodes.Number, expected: TypeName | None = None) -> Checked[TypeName | None]:
    """Return what the number measures; without a unit, whatever number is expected, in SI."""
    if not number.unit:
        is_number = expected is not None and expected.name in NUMBER_TYPES
        return expected if is_number else TypeName("number")
    if number.unit in UNITS:
        return TypeName(UNITS[number.unit][0])
    span = number.span if number.is_unit_shared else trailing_span(number.span, number.unit)
    kinds = [unit for unit, (kind, _) in UNITS.items() if expected and kind == expected.name]
    meant = in_our_units(number.value, number.unit)
    if meant is not None and meant.unit in (kinds or UNITS):
        yield _foreign_unit(number, meant, span)
        return TypeName(UNITS[meant.unit][0])
    help = f"there is: {', '.join(kinds or UNITS)}"
    if number.unit in AMBIGUOUS:
        help = f"it is {AMBIGUOUS[number.unit]}: write the number in one of the language's units"
    elif number.unit in PRODUCTS:
        help = f"it measures {PRODUCTS[number.unit]}, for which the language has no unit"
    yield Diagnostic("E107", f"there is no unit '{number.unit}'", span, (), help, None, number.unit)
    return None


def _foreign_unit(number: nodes.Number, meant: nodes.Number, span: Span) -> Diagnostic:
    """Write the same quantity in a unit of the language."""
    text = format_expression(meant)
    one = in_our_units(1.0, number.unit)  # 0 lb is 0 kg, and yet another unit
    if one is not None and one.value == 1.0:
        new = text if number.is_unit_shared else meant.unit
        message = f"there is no unit '{number.unit}'; it is written '{meant.unit}'"
        return Diagnostic("E107", message, span, fix=Fix(span, new, certain=True))
    message = f"there is no unit '{number.unit}'; this is '{text}'"
    return Diagnostic("E107", message, span, fix=Fix(number.span, text, certain=True))


def check_parameters(table: SymbolTable, parameters: Sequence[nodes.Parameter]) -> Checked[Names]:
    """Return the names that a signature declares, each once and of a type that exists."""
    names: dict[str, TypeName] = {}
    for parameter in parameters:
        if parameter.name in names:
            message = f"two parameters are called '{parameter.name}'"
            yield Diagnostic("E305", message, parameter.span)
        known = yield from check_type(table, parameter.type)
        names[parameter.name] = parameter.type if known else TypeName("")
        if known:
            yield from _check_range(table, parameter)
    return names


def _check_range(table: SymbolTable, parameter: nodes.Parameter) -> Iterator[Diagnostic]:
    low, high, type = parameter.low, parameter.high, parameter.type
    if low is None or high is None:
        return
    if type.name not in NUMBER_TYPES or type.is_list:
        message = f"only a number has a range, and '{parameter.name}' is {with_article(type)}"
        yield Diagnostic("E204", message, low.span, fix=Fix(_between(type.span, high.span), ""))
        return
    found = [each for bound in (low, high) for each in _check_bound(table, parameter, bound)]
    yield from found or check_order(low, high, low.span)


def _check_bound(table: SymbolTable, parameter: nodes.Parameter, bound: nodes.Number) -> Iterator[Diagnostic]:
    measured = yield from measure(bound, parameter.type)
    if measured is not None and not fits(table, measured, parameter.type):
        message = (
            f"'{parameter.name}' is {with_article(parameter.type)}, and this is {with_article(measured)}"
        )
        yield Diagnostic("E204", message, bound.span)


def check_order(low: nodes.Number, high: nodes.Number, span: Span) -> Iterator[Diagnostic]:
    """Check that a range does not end below its start, and has its unit at its end."""
    if low.unit and not high.unit and high.value:
        meant = format_expression(replace(high, unit=low.unit))
        help = f"without a unit it is in SI: write '{meant}', or the unit that is meant"
        fix = Fix(high.span, meant)
        yield Diagnostic("E203", "the upper bound of this range has no unit", high.span, help=help, fix=fix)
        return
    start, end = si(low), si(high)
    if start is None or end is None or start <= end:
        return
    swapped = Edit(high.span, format_expression(low))
    fix = Fix(low.span, format_expression(high), (swapped,))
    help = "the lower bound comes first"
    yield Diagnostic("E203", "this range is empty: it ends below its start", span, help=help, fix=fix)


def _between(before: Span, last: Span) -> Span:
    """Return the span from the end of one stretch to the end of another."""
    return Span(last.path, before.end_line, before.end_column, last.end_line, last.end_column)
