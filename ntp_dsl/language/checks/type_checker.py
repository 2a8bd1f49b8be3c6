"""Types of expressions: an object, a number, a member of an enumeration, or a condition."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from ntp_dsl.language.checks.applications import ApplicationChecker
from ntp_dsl.language.diagnostics.checked import Checked, outcome
from ntp_dsl.language.diagnostics.diagnostics import Diagnostic, Fix, unknown
from ntp_dsl.language.diagnostics.spelling import nearest
from ntp_dsl.language.names.signatures import Names, fits, measure, trailing_span, with_article
from ntp_dsl.language.names.symbol_table import NUMBER_TYPES, UNITS, SymbolTable
from ntp_dsl.language.repairs import argument_repairs
from ntp_dsl.language.syntax import nodes
from ntp_dsl.language.syntax.foreign_units import in_our_units
from ntp_dsl.language.syntax.formatter import format_expression
from ntp_dsl.language.syntax.nodes import Expression, TypeName

CONDITIONS = (nodes.Compare, nodes.Not, nodes.And, nodes.Or, nodes.Quantified)
ORDERED = {"<", "<=", ">", ">="}
TRUTHS = {"true": True, "false": False}  # literals of other languages


class TypeChecker:
    """Checks expressions against the symbol table."""

    def __init__(self, table: SymbolTable) -> None:
        self._table = table
        self._applications = ApplicationChecker(table, self.value)
        self.call = self._applications.call
        self.callee = self._applications.callee

    # Conditions

    def condition(self, expression: Expression, names: Names) -> Iterator[Diagnostic]:
        """Check that the expression is a condition."""
        match expression:
            case nodes.Atom():
                declared = yield from self._applications.predicate(expression, names)
                if declared is not None and declared.result is not None:
                    yield _not_a_truth(expression, declared.result)
            case nodes.Compare():
                yield from self._compare(expression, names)
            case nodes.Not(value):
                yield from self.condition(value, names)
            case nodes.And(values) | nodes.Or(values):
                for before, value in zip((None, *values), values, strict=False):
                    is_alternative = _is_alternative(expression, before)
                    without_left = self._without_left(value, before, names, is_alternative)
                    yield from [without_left] if without_left else self.condition(value, names)
            case nodes.Quantified(_, body, generators):
                inner = names
                for generator in generators:
                    inner = yield from self.generator(generator, inner, expression)
                yield from self.condition(body, inner)
            case nodes.Name(id) if id not in names and id in self._table.predicates:
                yield from self._bare_predicate(expression, self._table.predicates[id], names)
            case _:
                found = yield from self.value(expression, names, None)
                if found is not None:
                    yield _not_a_truth(expression, found)

    def _without_left(
        self, value: Expression, before: Expression | None, names: Names, is_alternative: bool
    ) -> Diagnostic | None:
        """Find `zone(c) == north or south`, where what is compared must be written again."""
        if not isinstance(before, nodes.Compare) or not isinstance(value, nodes.Name | nodes.Number):
            return None
        left, _ = outcome(self.value(before.left, names, None))
        found, _ = outcome(self.value(value, names, None))
        if left is None or found is None or not fits(self._table, found, left):
            return None
        meant = format_expression(replace(before, right=value))
        message = f"this is {with_article(found)}, where a condition is expected"
        fix = Fix(value.span, meant, certain=is_alternative)
        return Diagnostic("E205", message, value.span, help=f"did you mean '{meant}'?", fix=fix)

    def _bare_predicate(
        self, node: Expression, declared: nodes.PredicateDeclaration, names: Names
    ) -> Iterator[Diagnostic]:
        atom = nodes.Atom(declared.name, (), span=node.span)
        yield from self._applications.arguments.check(atom, declared, declared.parameters, names)
        if not declared.parameters:
            message = f"'{declared.name}' is a predicate and needs brackets"
            fix = Fix(node.span, f"{declared.name}()", certain=True)
            yield Diagnostic("E201", message, node.span, fix=fix)

    def generator(
        self, generator: nodes.Generator, names: Names, scope: nodes.Quantified | nodes.For
    ) -> Checked[Names]:
        """Return the names in scope inside the loop that the generator belongs to."""
        domain = generator.iterable
        element = yield from self._element(domain, names)
        if generator.variable in names or generator.variable in self._table.constants:
            message = f"'{generator.variable}' is defined here already"
            taken = {*names, *self._table.constants}
            fix = argument_repairs.rename(generator, scope, taken)
            help = "choose another name for the variable"
            yield Diagnostic("E306", message, generator.span, help=help, fix=fix)
        inner = {**names, generator.variable: element}
        if generator.condition is not None:
            yield from self.condition(generator.condition, inner)
        return inner

    def _element(self, domain: nodes.Name, names: Names) -> Checked[TypeName]:
        found = names.get(domain.id)
        if found is None and (domain.id in self._table.types or domain.id in self._table.enums):
            return TypeName(domain.id, span=domain.span)
        if found is not None and found.is_list:
            return TypeName(found.name)
        lists = [name for name, type in names.items() if type.is_list]
        of_records = [name for name in lists if names[name].name in self._table.records]
        if found is None and domain.id not in self._table.constants and len(of_records) == 1:
            known = [*lists, *self._table.types]
            if nearest(domain.id, known) is None and not domain.id[0].isupper():
                message = f"no list is called '{domain.id}'; did you mean '{of_records[0]}'?"
                only = Fix(domain.span, of_records[0])
                yield Diagnostic("E101", message, domain.span, fix=only, name=domain.id)
                return TypeName("")
        if found is None and domain.id not in self._table.constants:
            what, known = "no list or type is called", [*lists, *self._table.types]
            likely = self._table.types if domain.id[0].isupper() else known  # `Fruit` is no list `fruit`
            yield unknown("E101", what, domain.id, domain.span, known, likely=likely)
        elif found is None or found.name:
            one = found or self._table.constants[domain.id].type
            message = f"'{domain.id}' is one {one.name}, not a list to iterate over"
            fix = Fix(domain.span, lists[0]) if len(lists) == 1 else None
            if one.name in self._table.records and one.span.line:
                fix = Fix(one.span, f"list[{one.name}]")  # it is declared as a record, and iterated over
            help = "a loop iterates over a list, an enumeration, or the objects of a type: for b in Object"
            yield Diagnostic("E206", message, domain.span, help=help, fix=fix)
        return TypeName("")  # an unknown type, which fits everything: the error is reported already

    # Values

    def value(
        self, expression: Expression, names: Names, expected: TypeName | None
    ) -> Checked[TypeName | None]:
        """Return a value's type; None where something is wrong or anything would do."""
        match expression:
            case nodes.Name(id):
                return (yield from self._name(expression, id, names, expected))
            case nodes.Field():
                return (yield from self._field(expression, names, expected))
            case nodes.Number():
                return (yield from measure(expression, expected))
            case nodes.Arithmetic(_, left, right):
                return (yield from self._arithmetic(expression, left, right, names, expected))
            case nodes.Atom():
                declared = yield from self._applications.predicate(expression, names)
                if declared is None or declared.result is not None:
                    result = declared.result if declared else None
                    return result if result and result.name in self._table.type_names() else None
                if self._is_mistaken(declared):
                    return None
                message = f"'{declared.name}' is a condition, where a value is expected"
                help = f"a reading is declared with its type: predicate {declared.name}(...) -> length"
                fix = self._inside(expression, names, expected)
                yield Diagnostic("E205", message, expression.span, help=help, fix=fix)
                return None
            case nodes.Wildcard():
                help = "'any' is some object or member, as in holding(any); else say which"
                fix = self._only(expression, names, expected)
                message = "'any' is no particular object"
                yield Diagnostic("E207", message, expression.span, help=help, fix=fix)
                return None
        yield Diagnostic("E205", "this is a condition, where a value is expected", expression.span)
        return None

    def _inside(self, atom: nodes.Atom, names: Names, expected: TypeName | None) -> Fix | None:
        """Write `x` for `clear(x)`, where an object is meant."""
        if expected is None or len(atom.arguments) != 1:
            return None
        parameter = nodes.Parameter("", expected)
        is_meant = self._applications.arguments.takes([parameter], atom.arguments, names)
        return Fix(atom.span, format_expression(atom.arguments[0])) if is_meant else None

    def _name(
        self, node: Expression, name: str, names: Names, expected: TypeName | None
    ) -> Checked[TypeName | None]:
        if name in names:
            return names[name] if names[name].name else None
        if name in self._table.constants:
            return self._table.constants[name].type
        enums = self._table.enum_of(name)
        if enums:
            return TypeName(expected.name if expected and expected.name in enums else enums[0])
        yield self._no_name(node, name, names, expected)
        return None

    def _no_name(self, node: Expression, name: str, names: Names, expected: TypeName | None) -> Diagnostic:
        members = [member for enum in self._table.enums.values() for member in enum.members]
        known = [*names, *self._table.constants, *members]
        help = ""
        if name in UNITS or in_our_units(0.0, name) is not None:
            help = "a unit follows a number; products of units, such as a torque's, are not in the language"
            return Diagnostic("E101", f"nothing is called '{name}'", node.span, help=help, name=name)
        if numbered := _numbered(name, names):
            help = f"objects are numbered by their type, over all groups: here are {', '.join(numbered)}"
            return Diagnostic("E101", f"nothing is called '{name}'", node.span, help=help, name=name)
        if name in self._table.types:
            help = f"'{name}' is a type; an object of that type needs a parameter or a loop"
        likely = known if expected is None else self._of_type(expected, names)
        if (declared := self._table.predicates.get(name)) is not None:
            scope = self._applications.arguments.scope(names)
            meant = argument_repairs.repair_count(scope, declared.parameters, ())
            text = f"{name}({', '.join(map(format_expression, meant or ()))})"
            applied = Fix(node.span, text, certain=not meant) if meant is not None else None
            message = f"'{name}' is a predicate and needs brackets"
            help = f"for example: {text}" if applied else ""
            return Diagnostic("E101", message, node.span, help=help, fix=applied)
        if (owner := self._field_called(node, name, names)) is not None:
            message = f"nothing is called '{name}'; it is a field: {owner}"
            fix = Fix(node.span, owner, certain=nearest(name, likely) is None)
            return Diagnostic("E101", message, node.span, fix=fix, name=name)
        only = self._only(node, names, expected)
        if only is not None and nearest(name, likely) is None and nearest(name, known) is None:
            help = help or f"'{only.replacement}' would fit here"
            message = f"nothing is called '{name}'"
            return Diagnostic("E101", message, node.span, help=help, fix=only, name=name)
        return unknown("E101", "nothing is called", name, node.span, known, help, likely)

    def _field_called(self, node: Expression, name: str, names: Names) -> str | None:
        """Write `p.item` for `item`, if only one record in scope has such a field."""
        owners = [
            variable
            for variable, type in names.items()
            if type.name in self._table.records and not type.is_list
            if name in {each.name for each in self._table.records[type.name].fields}
        ]
        return f"{owners[0]}.{name}" if len(owners) == 1 else None

    def _of_type(self, type: TypeName, names: Names) -> list[str]:
        """Return all names of values that fit the type."""
        found = {**names, **{c.name: c.type for c in self._table.constants.values()}}
        enum = self._table.enums.get(type.name)
        fitting = [name for name, each in found.items() if fits(self._table, each, type)]
        return [*fitting, *(enum.members if enum else ())]

    def _only(self, node: Expression, names: Names, expected: TypeName | None) -> Fix | None:
        """Replace the node by the only object in scope of the expected type."""
        if expected is None:
            return None
        scope = argument_repairs.NamesInScope(self._table, names, lambda _, __: True)
        meant = scope.only(nodes.Parameter("", expected), ())
        return Fix(node.span, format_expression(meant)) if meant is not None else None

    def _field(self, node: nodes.Field, names: Names, expected: TypeName | None) -> Checked[TypeName | None]:
        if self._names_member(node, names):
            message = f"a member of an enumeration is written alone: {node.name}"
            yield Diagnostic("E101", message, node.span, fix=Fix(node.span, node.name, certain=True))
            return None
        type = yield from self._name(node.value, node.value.id, names, None)
        if type is None:
            return None
        record = self._table.records.get(type.name)
        if record is None or type.is_list:
            message = f"'{node.value.id}' is {with_article(type)}, which has no fields"
            help = f"iterate over it with: for p in {node.value.id}" if type.is_list else ""
            fix = self._applied(node, names) or self._owner(node, names)
            yield Diagnostic("E105", message, node.span, help=help, fix=fix)
            return None
        fields = {each.name: each.type for each in record.fields}
        if node.name not in fields:
            what = f"a {record.name} has no field"
            span = trailing_span(node.span, node.name)
            likely = [
                field
                for field, each in fields.items()
                if expected is None or fits(self._table, each, expected)
            ]
            wrong = unknown("E105", what, node.name, span, fields, likely=likely)
            if wrong.fix is None and len(likely) == 1 and expected is not None:
                wrong = replace(wrong, fix=Fix(span, likely[0]))
            yield wrong
        return fields.get(node.name)

    def _names_member(self, node: nodes.Field, names: Names) -> bool:
        """Recognise `Side.left`, where `left` alone is meant."""
        enum = self._table.enums.get(node.value.id)
        return enum is not None and node.value.id not in names and node.name in enum.members

    def _applied(self, node: nodes.Field, names: Names) -> Fix | None:
        """Write `drink(cup)` for `cup.drink`."""
        declared = self._table.predicates.get(node.name)
        takes = self._applications.arguments.takes
        if declared is None or not takes(declared.parameters, [node.value], names):
            return None
        return Fix(node.span, f"{node.name}({node.value.id})", certain=True)

    def _owner(self, node: nodes.Field, names: Names) -> Fix | None:
        """Write `p.item` for `goal.item`, if only `p` in scope has such a field."""
        owners = [
            name
            for name, type in names.items()
            if not type.is_list and type.name in self._table.records
            if node.name in {each.name for each in self._table.records[type.name].fields}
        ]
        return Fix(node.value.span, owners[0]) if len(owners) == 1 else None

    def _arithmetic(
        self,
        node: nodes.Arithmetic,
        left: Expression,
        right: Expression,
        names: Names,
        expected: TypeName | None,
    ) -> Checked[TypeName | None]:
        one = yield from self.value(left, names, expected)
        other = yield from self.value(right, names, expected)
        for side, type in ((left, one), (right, other)):
            if type is not None and (type.name not in NUMBER_TYPES or type.is_list):
                message = f"'{node.operator}' takes numbers, and this is {with_article(type)}"
                yield Diagnostic("E204", message, side.span)
                return None
        return (yield from _measure(node, one, other))

    def _compare(self, node: nodes.Compare, names: Names) -> Iterator[Diagnostic]:
        truths = [side for side in (node.left, node.right) if self._is_truth(side)]
        for truth in truths:
            yield from self.condition(truth, names)
        if truths:
            yield _compared_truth(node, truths[0])
            return
        left = yield from self.value(node.left, names, None)
        right = yield from self.value(node.right, names, left)
        if left is None or right is None:
            return
        if not (fits(self._table, left, right) or fits(self._table, right, left)):
            message = f"{with_article(left)} cannot be compared with {with_article(right)}"
            yield Diagnostic("E208", message, node.span)
        elif node.operator in ORDERED and left.name not in NUMBER_TYPES:
            message = f"'{node.operator}' orders numbers, and each of these is {with_article(left)}"
            yield Diagnostic("E208", message, node.span)

    def _is_truth(self, side: Expression) -> bool:
        if isinstance(side, nodes.Atom):
            declared = self._table.predicates.get(side.predicate)
            return declared is not None and declared.result is None and not self._is_mistaken(declared)
        return isinstance(side, CONDITIONS)

    def _is_mistaken(self, declared: nodes.PredicateDeclaration) -> bool:
        """Return whether it is a `predicate drink(cup: Cup): Drink`, which is reported by itself."""
        return isinstance(declared.body, nodes.Name) and declared.body.id in self._table.type_names()


def _is_alternative(whole: nodes.And | nodes.Or, compared: Expression | None) -> bool:
    """Recognise `x == a or b` and `x != a and b`, in which the other values can only be alternatives to a."""
    sign = "==" if isinstance(whole, nodes.Or) else "!="
    return isinstance(compared, nodes.Compare) and compared.operator == sign


def _not_a_truth(expression: Expression, found: TypeName) -> Diagnostic:
    message = f"this is {with_article(found)}, where a condition is expected"
    help = "a condition is a predicate, a comparison, or several joined with and, or, not"
    return Diagnostic("E205", message, expression.span, help=help)


def _measure(
    node: nodes.Arithmetic, left: TypeName | None, right: TypeName | None
) -> Checked[TypeName | None]:
    if left is None or right is None or node.operator in "*/":
        return None  # the unit of a product is not checked
    if left != right and "number" not in (left.name, right.name):
        message = f"'{node.operator}' cannot join {with_article(left)} with {with_article(right)}"
        yield Diagnostic("E204", message, node.span)
        return None
    return right if left.name == "number" else left


def _compared_truth(node: nodes.Compare, truth: Expression) -> Diagnostic:
    """Report `clear(x) == True`: a predicate needs no such comparison."""
    other = node.right if truth is node.left else node.left
    word = TRUTHS.get(other.id.lower()) if isinstance(other, nodes.Name) else None
    message = "a condition is not compared; it is written alone, or after 'not'"
    fix = None
    if word is not None and node.operator in {"==", "!="}:
        meant = truth if word == (node.operator == "==") else nodes.Not(truth)
        fix = Fix(node.span, format_expression(meant), certain=True)
    return Diagnostic("E205", message, node.span, fix=fix)


def _numbered(name: str, names: Names) -> list[str]:
    """Return the numbered objects of a group's type, where a name is that group's and a number."""
    group, _, number = name.rpartition("_")
    if not number.isdigit():
        return []
    types = [type.name for each, type in names.items() if type.is_list and each in (group, f"{group}s")]
    stems = tuple(f"{type.lower()}_" for type in types)
    return [each for each in names if each.startswith(stems) and each.rpartition("_")[2].isdigit()]
