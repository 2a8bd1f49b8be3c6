"""Repairs of arguments that do not fit: others in scope, in another order, fewer or more."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations, count, permutations

from ntp_dsl.language.diagnostics.diagnostics import Edit, Fix
from ntp_dsl.language.names.signatures import Names, fits
from ntp_dsl.language.names.symbol_table import SymbolTable
from ntp_dsl.language.syntax import nodes
from ntp_dsl.language.syntax.formatter import format_expression
from ntp_dsl.language.syntax.nodes import Expression, Field, Name, Parameter, Span, TypeName
from ntp_dsl.language.syntax.visitors import walk_statement

Arguments = tuple[Expression, ...]
MAX_ARGUMENTS = 5  # up to which every order and choice is tried


@dataclass(frozen=True)
class NamesInScope:
    """The names in scope at a place, and a test of what fits a parameter there, which reports nothing."""

    table: SymbolTable
    names: Names
    accepts: Callable[[Parameter, Expression], bool]

    def takes(self, parameters: Sequence[Parameter], arguments: Sequence[Expression]) -> bool:
        return all(map(self.accepts, parameters, arguments))

    def of_type(self, expected: TypeName) -> Iterator[Expression]:
        """Yield parameters, variables and their fields that are of the type."""
        for name, type in self.names.items():
            if type.name and fits(self.table, type, expected):
                yield Name(name)
            record = self.table.records.get(type.name)
            if record is not None and not type.is_list:
                for each in record.fields:
                    if fits(self.table, each.type, expected):
                        yield Field(Name(name), each.name)

    def only(self, parameter: Parameter, given: Sequence[Expression]) -> Expression | None:
        """Return the one expression that fits the parameter: of its name, or the only one not given yet."""
        if parameter.type.name not in self.table.type_names():
            return None
        open = [each for each in self.of_type(parameter.type) if each not in given]
        named = [each for each in open if _last_name(each) == parameter.name]
        if len(named) == 1:
            return named[0]
        if open:
            return open[0] if len(open) == 1 else None
        constants = self.table.constants.values()
        fitting = [Name(c.name) for c in constants if fits(self.table, c.type, parameter.type)]
        left = [each for each in fitting if each not in given]
        return left[0] if len(left) == 1 else None


def _last_name(expression: Expression) -> str:
    return expression.name if isinstance(expression, Field) else getattr(expression, "id", "")


def repair_count(scope: NamesInScope, parameters: Sequence[Parameter], given: Arguments) -> Arguments | None:
    """Return as many arguments as there are parameters, if it is clear which are missing or too many."""
    wanted, found = len(parameters), len(given)
    if max(wanted, found) > MAX_ARGUMENTS:
        return None
    if found > wanted:
        numbers = {
            each for each in given if isinstance(each, nodes.Number)
        }  # which nobody writes by accident
        choices = [
            each
            for each in combinations(given, wanted)
            if numbers <= {*each} and scope.takes(parameters, each)
        ]
        distinct = [each for each in choices if len(set(each)) == len(each)]
        return next(iter(distinct or choices), None)
    fields = _fields_of(scope, given[0]) if found == 1 else ()
    if len(fields) == wanted and scope.takes(parameters, fields):
        return fields
    filled = (_fill(scope, parameters, given, kept) for kept in combinations(range(wanted), found))
    return next((each for each in filled if each is not None), None)


def decimal_points(given: Sequence[nodes.Node], wanted: int) -> Fix | None:
    """Write `0.5 kg` for `0,5 kg`, which is read as two elements, if that leaves as many as are wanted."""
    pairs = [
        (before, after)
        for before, after in zip(map(_last_number, given), map(_first_number, given[1:]), strict=False)
        if before is not None and after is not None and _are_one_number(before, after)
    ]
    if not pairs or len(given) - len(pairs) != wanted:
        return None
    edits = [Edit(_until(before.span, after.span), ".") for before, after in pairs]
    return Fix(edits[0].span, edits[0].replacement, tuple(edits[1:]), certain=True)


def _last_number(node: nodes.Node) -> nodes.Number | None:
    if isinstance(node, nodes.Interval):
        return node.high
    return node if isinstance(node, nodes.Number) else None


def _first_number(node: nodes.Node) -> nodes.Number | None:
    if isinstance(node, nodes.Interval):
        return node.low
    return node if isinstance(node, nodes.Number) else None


def _are_one_number(before: nodes.Number, after: nodes.Number) -> bool:
    """Recognise `0,5 kg`; not `1,500 kg`, which may be a thousand and a half."""
    whole, rest = before.span, after.span
    is_close = whole.end_line == rest.line and whole.end_column + 1 == rest.column
    digits = f"{abs(before.value):.0f}"
    is_whole = whole.end_column - whole.column == len(digits) + (before.value < 0) and not before.unit
    decimals = rest.end_column - rest.column - len(after.unit)  # perhaps with blanks before the unit
    is_plain = after.value >= 0 and after.value == int(after.value)
    may_be_thousands = digits != "0" and len(f"{after.value:.0f}") == 3 or (digits != "0" and decimals == 3)
    return is_close and is_whole and is_plain and not may_be_thousands


def _until(before: Span, after: Span) -> Span:
    return Span(after.path, before.end_line, before.end_column, after.line, after.column)


def _fields_of(scope: NamesInScope, whole: Expression) -> Arguments:
    """Return `p.item, p.support` for `p`."""
    type = scope.names.get(whole.id) if isinstance(whole, Name) else None
    record = scope.table.records.get(type.name) if type is not None and not type.is_list else None
    if record is None or not isinstance(whole, Name):
        return ()
    return tuple(Field(whole, each.name) for each in record.fields)


def _fill(
    scope: NamesInScope, parameters: Sequence[Parameter], given: Arguments, kept: tuple[int, ...]
) -> Arguments | None:
    """Return the given arguments at these positions, and at the others the only ones that fit."""
    if not scope.takes([parameters[index] for index in kept], given):
        return None
    places = dict(zip(kept, given, strict=True))
    for index, parameter in enumerate(parameters):
        if index not in places:
            meant = scope.only(parameter, tuple(places.values()))
            if meant is None:
                return None
            places[index] = meant
    return tuple(places[index] for index in range(len(parameters)))


def repair_order(scope: NamesInScope, parameters: Sequence[Parameter], given: Arguments) -> Arguments | None:
    """Return the one other order in which everything fits."""
    if len(given) > MAX_ARGUMENTS:
        return None
    orders = {order for order in permutations(given) if scope.takes(parameters, order)}
    return orders.pop() if len(orders) == 1 else None


def repair_argument(
    scope: NamesInScope, parameters: Sequence[Parameter], given: Arguments, index: int
) -> Expression | None:
    """Return what was meant for one argument: a part of it, or the only expression that fits."""
    wrong, parameter = given[index], parameters[index]
    if isinstance(wrong, nodes.Atom) and len(wrong.arguments) == 1:
        whole = wrong.arguments[0]  # drink(order), where order.drink is meant
        if isinstance(whole, Name) and scope.accepts(parameter, Field(whole, wrong.predicate)):
            return Field(whole, wrong.predicate)
    parts = [each for each in scope.of_type(parameter.type) if _is_part(each, wrong, scope.names)]
    named = [each for each in parts if _last_name(each) == parameter.name]
    if len(parts) == 1 or len(named) == 1:
        return (named or parts)[0]
    if isinstance(wrong, nodes.Atom) and len(wrong.arguments) == 1:
        if scope.accepts(parameter, wrong.arguments[0]):
            return wrong.arguments[0]  # pick(clear(x)), where pick(x) is meant
    return scope.only(parameter, given)


def is_only_part(scope: NamesInScope, parameter: Parameter, whole: Expression, meant: Expression) -> bool:
    """Return whether `p.item`, for `p`, is all that fits here: then nothing else can be meant."""
    constants = [Name(each.name) for each in scope.table.constants.values()]
    fitting = [
        *scope.of_type(parameter.type),
        *(each for each in constants if scope.accepts(parameter, each)),
    ]
    is_part = isinstance(meant, Field) and isinstance(whole, Name) and meant.value.id == whole.id
    return is_part and fitting == [meant]


def as_field(scope: NamesInScope, atom: nodes.Node) -> Fix | None:
    """Write `order.drink` for `drink(order)`."""
    match atom:
        case nodes.Atom(name, (Name(id),)) if id in scope.names and not scope.names[id].is_list:
            record = scope.table.records.get(scope.names[id].name)
            if record is not None and name in {each.name for each in record.fields}:
                return Fix(atom.span, f"{id}.{name}", certain=name not in scope.table.predicates)
    return None


def _is_part(part: Expression, whole: Expression, names: Names) -> bool:
    """Return whether it is like `p.item` of `p`; or of `goal`, if p is an element of such a list."""
    if not isinstance(whole, Name) or not isinstance(part, Field):
        return False
    return part.value.id == whole.id or (
        whole.id in names and names[part.value.id].name == names[whole.id].name
    )


def narrower(scope: NamesInScope, parameter: Parameter, wrong: Expression) -> Fix | None:
    """Narrow the declared type of what is given: `item: Place` in place of `item: Object`."""
    declared = scope.names.get(wrong.id) if isinstance(wrong, Name) else None
    if declared is None or declared.is_list or declared.span.path != wrong.span.path:
        return None
    wider = declared.span.line and scope.table.is_a(parameter.type.name, declared.name)
    return Fix(declared.span, parameter.type.name) if wider else None


def as_call(node: nodes.Atom | nodes.Call, name: str, arguments: Arguments, certain: bool = False) -> Fix:
    """Write the call, or predicate, with these arguments instead."""
    return Fix(node.span, f"{name}({', '.join(map(format_expression, arguments))})", certain=certain)


def rename(generator: nodes.Generator, scope: nodes.Quantified | nodes.For, taken: set[str]) -> Fix | None:
    """Rename the variable, and every use in its loop, to a name that is not taken.

    None where a predicate has the name twice: one of the two means the outer name.
    """
    old = generator.variable
    for each in walk_statement(scope):
        if isinstance(each, nodes.Atom) and each.arguments.count(Name(old)) > 1:
            return None
    new = next(name for name in _names_for(generator) if name not in taken)
    uses = [
        Edit(each.span, new)
        for each in walk_statement(scope)
        if isinstance(each, Name) and each.id == old and each is not generator.iterable
    ]
    place = Span(
        generator.span.path,
        generator.span.line,
        generator.span.column,
        generator.span.line,
        generator.span.column + len(old),
    )
    return Fix(place, new, tuple(uses))


def _names_for(generator: nodes.Generator) -> Iterator[str]:
    """Yield the type's first letter, as is the custom, then the old name with a number."""
    yield generator.iterable.id[0].lower()
    yield from (f"{generator.variable}_{number}" for number in count(2))
