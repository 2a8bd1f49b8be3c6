"""Checks of arguments against parameters: their number, types and ranges."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence

from ntp_dsl.language.diagnostics.checked import Checked, outcome
from ntp_dsl.language.diagnostics.diagnostics import Diagnostic, Fix, Note
from ntp_dsl.language.names.signatures import Names, are_given, counted, fits, leading_span, si, with_article
from ntp_dsl.language.names.symbol_table import NUMBER_TYPES, UNITS, SymbolTable
from ntp_dsl.language.repairs import argument_repairs
from ntp_dsl.language.syntax import nodes
from ntp_dsl.language.syntax.formatter import format_expression, format_type
from ntp_dsl.language.syntax.nodes import Expression, Parameter, TypeName

Value = Callable[[Expression, Names, TypeName | None], Checked[TypeName | None]]
FAR_OUT = 5.0  # a number so many times beyond its range was meant in another unit


class ArgumentChecker:
    """Checks arguments; `value` checks one by itself and returns its type."""

    def __init__(self, table: SymbolTable, value: Value) -> None:
        self._table = table
        self._value = value

    def check(
        self,
        node: nodes.Atom | nodes.Call,
        declared: nodes.Declaration,
        parameters: Sequence[Parameter],
        names: Names,
        allow_wildcard: bool = False,
    ) -> Iterator[Diagnostic]:
        """Check that there are as many as declared, each of its parameter's type and in its range.

        Args:
            allow_wildcard: whether `any` may stand for an argument.
        """
        given = node.arguments
        note = Note(f"'{declared.name}' is declared here", declared.name_span)
        scope = self.scope(names, allow_wildcard)
        if len(parameters) != len(given):
            yield from self.check_alone(node, names)
            yield self._wrong_number(node, declared, parameters, scope, note)
            return
        for index, argument in enumerate(given):
            if isinstance(argument, nodes.Wildcard) and allow_wildcard and self._has_any(parameters[index]):
                continue
            found = yield from self._value(argument, names, parameters[index].type)
            if found is None:
                continue
            if not fits(self._table, found, parameters[index].type):
                yield self._wrong_type(node, declared, parameters, index, found, scope, note)
                if argument_repairs.repair_order(scope, parameters, given) is not None:
                    return  # they are only in the wrong order, which is one mistake
            elif isinstance(argument, nodes.Number):
                yield from _check_range(parameters[index], argument, note)

    def _has_any(self, parameter: Parameter) -> bool:
        """Return whether a parameter is of objects or members, of which `any` may be one."""
        type = parameter.type
        return not (type.is_list or type.name in self._table.records or type.name in NUMBER_TYPES)

    def check_alone(self, node: nodes.Atom | nodes.Call, names: Names) -> Iterator[Diagnostic]:
        """Check the arguments by themselves, where the parameters are not known."""
        for argument in node.arguments:
            if not isinstance(argument, nodes.Wildcard):
                yield from self._value(argument, names, None)

    def scope(self, names: Names, allow_wildcard: bool = True) -> argument_repairs.NamesInScope:
        """Return the names in scope here, and a test of what fits a parameter."""
        return argument_repairs.NamesInScope(self._table, names, self._accepts(names, allow_wildcard))

    def takes(self, parameters: Sequence[Parameter], arguments: Sequence[Expression], names: Names) -> bool:
        """Return whether the arguments fit; report nothing."""
        accepts = self._accepts(names, allow_wildcard=True)
        return len(parameters) == len(arguments) and all(map(accepts, parameters, arguments))

    def _accepts(self, names: Names, allow_wildcard: bool) -> Callable[[Parameter, Expression], bool]:
        def accepts(parameter: Parameter, argument: Expression) -> bool:
            if isinstance(argument, nodes.Wildcard):
                return allow_wildcard and self._has_any(parameter)
            found, wrong = outcome(self._value(argument, names, parameter.type))
            return not wrong and (found is None or fits(self._table, found, parameter.type))

        return accepts

    def _wrong_number(
        self,
        node: nodes.Atom | nodes.Call,
        declared: nodes.Declaration,
        parameters: Sequence[Parameter],
        scope: argument_repairs.NamesInScope,
        note: Note,
    ) -> Diagnostic:
        wanted, found = len(parameters), len(node.arguments)
        message = f"'{declared.name}' takes {counted(wanted, 'argument')}, and {are_given(found)}"
        meant = argument_repairs.repair_count(scope, parameters, node.arguments)
        fix = argument_repairs.decimal_points(node.arguments, wanted)
        if fix is None and meant is not None:
            fields = [each.name for each in meant if isinstance(each, nodes.Field)]
            is_whole = found == 1 and bool(fields) and fields == [each.name for each in parameters]
            fix = argument_repairs.as_call(node, declared.name, meant, certain=is_whole)
        listing = ", ".join(f"{each.name}: {format_type(each.type)}" for each in parameters)
        help = f"it is declared: {declared.name}({listing})"
        return Diagnostic("E201", message, leading_span(node.span, declared.name), (note,), help, fix)

    def _wrong_type(
        self,
        node: nodes.Atom | nodes.Call,
        declared: nodes.Declaration,
        parameters: Sequence[Parameter],
        index: int,
        found: TypeName,
        scope: argument_repairs.NamesInScope,
        note: Note,
    ) -> Diagnostic:
        parameter, wrong = parameters[index], node.arguments[index]
        message = f"'{parameter.name}' is {with_article(parameter.type)}, and this is {with_article(found)}"
        help = self._members(parameter.type)
        order = argument_repairs.repair_order(scope, parameters, node.arguments)
        meant = argument_repairs.repair_argument(scope, parameters, node.arguments, index)
        if (field := argument_repairs.as_field(scope, node)) is not None:
            fix: Fix | None = field
            help = f"did you mean the field: {field.replacement}?"
        elif order is not None:
            fix = argument_repairs.as_call(node, declared.name, order, certain=True)
            help = f"in this order they fit: {fix.replacement}" if fix else help
        elif isinstance(wrong, nodes.Number) and parameter.type.name in NUMBER_TYPES:
            fix = None
            help = _in_its_unit(parameter, wrong) or help
        elif meant is not None:
            certain = argument_repairs.is_only_part(scope, parameter, wrong, meant)
            fix = Fix(wrong.span, format_expression(meant), certain=certain)
            help = help or f"did you mean '{fix.replacement}'?"
        else:
            fix = argument_repairs.narrower(scope, parameter, wrong)
            if fix is not None:
                help = f"only {with_article(parameter.type)} fits: narrow its declared type"
        return Diagnostic("E202", message, wrong.span, (note,), help, fix)

    def _members(self, type: TypeName) -> str:
        enum = self._table.enums.get(type.name)
        return f"{with_article(type)} is one of: {', '.join(enum.members)}" if enum else ""


def _check_range(parameter: Parameter, number: nodes.Number, note: Note) -> Iterator[Diagnostic]:
    value, low, high = map(si, (number, parameter.low, parameter.high))
    if value is None or low is None or high is None or low <= value <= high:
        return
    unit = _unit(parameter)
    message = f"'{parameter.name}' must be in {low:g} .. {high:g}{unit}, and this is {value:g}{unit}"
    yield Diagnostic("E203", message, number.span, (note,), _other_unit(parameter, number, value, low, high))


def _unit(parameter: Parameter) -> str:
    kinds = [unit for unit, (kind, size) in UNITS.items() if (kind, size) == (parameter.type.name, 1)]
    return f" {kinds[0]}" if kinds else ""


def _in_its_unit(parameter: Parameter, number: nodes.Number) -> str:
    """Ask for `30 s` in place of 30 cm where a time is meant: the only unit, or the only one in the range."""
    low, high = si(parameter.low), si(parameter.high)
    kinds = [(size, unit) for unit, (kind, size) in UNITS.items() if kind == parameter.type.name]
    if low is not None and high is not None:
        kinds = [(size, unit) for size, unit in kinds if low <= number.value * size <= high]
    return _did_you_mean(number, kinds[0][1]) if len(kinds) == 1 else ""


def _did_you_mean(number: nodes.Number, unit: str) -> str:
    """Ask for another unit, in words only: a quantity is never guessed."""
    return f"did you mean {format_expression(nodes.Number(number.value, unit))}?"


def _other_unit(parameter: Parameter, number: nodes.Number, value: float, low: float, high: float) -> str:
    """Ask for 30 cm in place of 30 where at most 0.3 m are allowed: the largest unit that fits."""
    if number.unit and abs(value) < FAR_OUT * max(abs(low), abs(high)):
        return ""
    kinds = [(size, unit) for unit, (kind, size) in UNITS.items() if kind == parameter.type.name]
    for size, unit in sorted(kinds, reverse=True):
        if low <= number.value * size <= high:
            return _did_you_mean(number, unit)
    return ""
