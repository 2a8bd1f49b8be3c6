"""What was probably meant by arguments that do not fit: others in sight, in another order, fewer or more."""

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
from ntp_dsl.language.syntax.visitors import inside

Arguments = tuple[Expression, ...]
FEW = 5  # arguments, up to which every order and choice is tried


@dataclass(frozen=True)
class Sight:
    """What can be named at a place, and what an expression there would be; says nothing aloud."""

    table: SymbolTable
    names: Names
    accepts: Callable[[Parameter, Expression], bool]

    def takes(self, parameters: Sequence[Parameter], arguments: Sequence[Expression]) -> bool:
        return all(map(self.accepts, parameters, arguments))

    def things(self, expected: TypeName) -> Iterator[Expression]:
        """Parameters, variables and their fields that are of the type."""
        for name, type in self.names.items():
            if type.name and fits(self.table, type, expected):
                yield Name(name)
            record = self.table.records.get(type.name)
            if record is not None and not type.is_list:
                for each in record.fields:
                    if fits(self.table, each.type, expected):
                        yield Field(Name(name), each.name)

    def only(self, parameter: Parameter, given: Sequence[Expression]) -> Expression | None:
        """The one thing that the parameter can mean: of its name, or the only one not given yet."""
        if parameter.type.name not in self.table.type_names():
            return None
        open = [each for each in self.things(parameter.type) if each not in given]
        named = [each for each in open if _last_name(each) == parameter.name]
        if len(named) == 1:
            return named[0]
        if open:
            return open[0] if len(open) == 1 else None
        constants = self.table.constants.values()
        fitting = [Name(c.name) for c in constants if fits(self.table, c.type, parameter.type)]
        left = [each for each in fitting if each not in given]
        return left[0] if len(left) == 1 else None


def _last_name(thing: Expression) -> str:
    return thing.name if isinstance(thing, Field) else getattr(thing, "id", "")


def repair_count(sight: Sight, parameters: Sequence[Parameter], given: Arguments) -> Arguments | None:
    """As many arguments as there are parameters, if it is clear which are missing or too many."""
    wanted, found = len(parameters), len(given)
    if max(wanted, found) > FEW:
        return None
    if found > wanted:
        choices = [each for each in combinations(given, wanted) if sight.takes(parameters, each)]
        distinct = [each for each in choices if len(set(each)) == len(each)]
        return next(iter(distinct or choices), None)
    fields = _fields_of(sight, given[0]) if found == 1 else ()
    if len(fields) == wanted and sight.takes(parameters, fields):
        return fields
    filled = (_fill(sight, parameters, given, kept) for kept in combinations(range(wanted), found))
    return next((each for each in filled if each is not None), None)


def _fields_of(sight: Sight, whole: Expression) -> Arguments:
    """`p.item, p.support` of `p`."""
    type = sight.names.get(whole.id) if isinstance(whole, Name) else None
    record = sight.table.records.get(type.name) if type is not None and not type.is_list else None
    if record is None or not isinstance(whole, Name):
        return ()
    return tuple(Field(whole, each.name) for each in record.fields)


def _fill(
    sight: Sight, parameters: Sequence[Parameter], given: Arguments, kept: tuple[int, ...]
) -> Arguments | None:
    """The given arguments at these positions, and at the others the only thing that can be meant."""
    if not sight.takes([parameters[index] for index in kept], given):
        return None
    places = dict(zip(kept, given, strict=True))
    for index, parameter in enumerate(parameters):
        if index not in places:
            meant = sight.only(parameter, tuple(places.values()))
            if meant is None:
                return None
            places[index] = meant
    return tuple(places[index] for index in range(len(parameters)))


def repair_order(sight: Sight, parameters: Sequence[Parameter], given: Arguments) -> Arguments | None:
    """The one other order in which everything fits."""
    if len(given) > FEW:
        return None
    orders = {order for order in permutations(given) if sight.takes(parameters, order)}
    return orders.pop() if len(orders) == 1 else None


def repair_argument(
    sight: Sight, parameters: Sequence[Parameter], given: Arguments, index: int
) -> Expression | None:
    """What was meant at one place: a part of what stands there, or the only thing that fits."""
    wrong, parameter = given[index], parameters[index]
    if isinstance(wrong, nodes.Atom) and len(wrong.arguments) == 1:
        whole = wrong.arguments[0]  # drink(order), where order.drink is meant
        if isinstance(whole, Name) and sight.accepts(parameter, Field(whole, wrong.predicate)):
            return Field(whole, wrong.predicate)
    parts = [each for each in sight.things(parameter.type) if _is_part(each, wrong, sight.names)]
    named = [each for each in parts if _last_name(each) == parameter.name]
    if len(parts) == 1 or len(named) == 1:
        return (named or parts)[0]
    if isinstance(wrong, nodes.Atom) and len(wrong.arguments) == 1:
        if sight.accepts(parameter, wrong.arguments[0]):
            return wrong.arguments[0]  # pick(clear(x)), where pick(x) is meant
    return sight.only(parameter, given)


def as_field(sight: Sight, atom: nodes.Node) -> Fix | None:
    """`order.drink` where `drink(order)` is written."""
    match atom:
        case nodes.Atom(name, (Name(id),)) if id in sight.names and not sight.names[id].is_list:
            record = sight.table.records.get(sight.names[id].name)
            if record is not None and name in {each.name for each in record.fields}:
                return Fix(atom.span, f"{id}.{name}")
    return None


def _is_part(thing: Expression, whole: Expression, names: Names) -> bool:
    """`p.item` of `p`; and of `goal`, if p is an element of such a list."""
    if not isinstance(whole, Name) or not isinstance(thing, Field):
        return False
    return thing.value.id == whole.id or (
        whole.id in names and names[thing.value.id].name == names[whole.id].name
    )


def narrower(sight: Sight, parameter: Parameter, wrong: Expression) -> Fix | None:
    """`item: Place` where every Object would fit: the declaration of what is given is too wide."""
    declared = sight.names.get(wrong.id) if isinstance(wrong, Name) else None
    if declared is None or declared.is_list or declared.span.path != wrong.span.path:
        return None
    wider = declared.span.line and sight.table.is_a(parameter.type.name, declared.name)
    return Fix(declared.span, parameter.type.name) if wider else None


def as_call(node: nodes.Atom | nodes.Call, name: str, arguments: Arguments) -> Fix:
    """The call, or predicate, with these arguments instead."""
    return Fix(node.span, f"{name}({', '.join(map(format_expression, arguments))})")


def rename(generator: nodes.Generator, scope: nodes.Quantified | nodes.For, taken: set[str]) -> Fix | None:
    """The variable, and every mention of it in its loop, under a name that is not taken.

    None where a predicate has the name twice: one of the two is meant to be the other thing.
    """
    old = generator.variable
    for each in inside(scope):
        if isinstance(each, nodes.Atom) and each.arguments.count(Name(old)) > 1:
            return None
    new = next(name for name in _names_for(generator) if name not in taken)
    uses = [
        Edit(each.span, new)
        for each in inside(scope)
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
    """The type's first letter, as is the custom; else the old name with a number."""
    yield generator.iterable.id[0].lower()
    yield from (f"{generator.variable}_{number}" for number in count(2))
