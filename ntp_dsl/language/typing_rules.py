"""What an expression stands for: a thing, a number, a member of an enumeration, or a truth."""

from __future__ import annotations

from collections.abc import Sequence

from ntp_dsl.language import syntax
from ntp_dsl.language.diagnostics import Diagnostic, Note, nearest, unknown
from ntp_dsl.language.formatter import format_type
from ntp_dsl.language.names import NUMBER_TYPES, Table
from ntp_dsl.language.signatures import Names, fits, head, measure, phrase, si, tail
from ntp_dsl.language.syntax import Expression, Span, TypeName

CONDITIONS = (syntax.Compare, syntax.Not, syntax.And, syntax.Or, syntax.Quantified)
ORDERED = {"<", "<=", ">", ">="}


class Typing:
    """Checks expressions against the table, and leaves what is wrong in its `mistakes`."""

    def __init__(self, table: Table) -> None:
        self._table = table

    # Truths

    def condition(self, expression: Expression, names: Names) -> None:
        """The expression must be true or false."""
        match expression:
            case syntax.Atom():
                declared = self._predicate(expression, names)
                if declared is not None and declared.result is not None:
                    self._not_a_truth(expression, f"{phrase(declared.result)}")
            case syntax.Compare():
                self._compare(expression, names)
            case syntax.Not(value):
                self.condition(value, names)
            case syntax.And(values) | syntax.Or(values):
                for value in values:
                    self.condition(value, names)
            case syntax.Quantified(_, body, generators):
                inner = names
                for generator in generators:
                    inner = self.generator(generator, inner)
                self.condition(body, inner)
            case _:
                found = self.value(expression, names, None)
                if found is not None:
                    self._not_a_truth(expression, f"{phrase(found)}")

    def _not_a_truth(self, expression: Expression, what: str) -> None:
        message = f"this is {what}, where something true or false is meant"
        help = "a condition is a predicate, a comparison, or several joined with and, or, not"
        self._table.report("E205", message, expression.span, help)

    def generator(self, generator: syntax.Generator, names: Names) -> Names:
        """The names in sight inside the loop."""
        domain = generator.iterable
        element = self._element(domain, names)
        if generator.variable in names or generator.variable in self._table.constants:
            message = f"'{generator.variable}' has a meaning here already"
            self._table.report(
                "E306", message, generator.span, "choose another name for the variable"
            )
        inner = {**names, generator.variable: element}
        if generator.condition is not None:
            self.condition(generator.condition, inner)
        return inner

    def _element(self, domain: syntax.Name, names: Names) -> TypeName:
        found = names.get(domain.id)
        if found is None and domain.id in self._table.types:
            return TypeName(domain.id)
        if found is not None and found.is_list:
            return TypeName(found.name)
        if found is not None:
            message = f"'{domain.id}' is one {found.name}, not a list to go through"
            self._table.report("E206", message, domain.span)
        else:
            lists = [name for name, type in names.items() if type.is_list]
            self._table.mistakes.append(
                unknown("E101", "no list or type is called", domain.id, domain.span,
                        [*lists, *self._table.types])
            )  # fmt: skip
        return TypeName("")  # stands for "said already": it fits everything

    # Values

    def value(
        self, expression: Expression, names: Names, expected: TypeName | None
    ) -> TypeName | None:
        """A value's type; None where a mistake was reported or anything would do."""
        match expression:
            case syntax.Name(id):
                return self._name(expression, id, names, expected)
            case syntax.Field():
                return self._field(expression, names)
            case syntax.Number():
                return measure(self._table, expression, expected)
            case syntax.Arithmetic(_, left, right):
                return self._arithmetic(expression, left, right, names, expected)
            case syntax.Atom():
                declared = self._predicate(expression, names)
                if declared is None or declared.result is not None:
                    return declared.result if declared else None
                message = f"'{declared.name}' is true or false; here a value is meant"
                help = (
                    f"a reading is declared with its type: predicate {declared.name}(...) -> length"
                )
                self._table.report("E205", message, expression.span, help)
                return None
            case syntax.Wildcard():
                help = "'any' stands in a predicate's argument, as in holding(any)"
                self._table.report("E207", "'any' names no particular thing", expression.span, help)
                return None
        self._table.report("E205", "this is true or false; here a value is meant", expression.span)
        return None

    def _name(
        self, node: Expression, name: str, names: Names, expected: TypeName | None
    ) -> TypeName | None:
        if name in names:
            return names[name] if names[name].name else None
        if name in self._table.constants:
            return self._table.constants[name].type
        enums = self._table.enum_of(name)
        if enums:
            return TypeName(expected.name if expected and expected.name in enums else enums[0])
        members = [member for enum in self._table.enums.values() for member in enum.members]
        known = [*names, *self._table.constants, *members]
        help = ""
        if name in self._table.types:
            help = f"'{name}' is a type; a thing of that type needs a parameter or a loop"
        self._table.mistakes.append(
            unknown("E101", "nothing is called", name, node.span, known, help)
        )
        return None

    def _field(self, node: syntax.Field, names: Names) -> TypeName | None:
        type = self._name(node.value, node.value.id, names, None)
        if type is None:
            return None
        record = self._table.records.get(type.name)
        if record is None or type.is_list:
            message = f"'{node.value.id}' is {phrase(type)}, which has no fields"
            help = f"go through it with: for p in {node.value.id}" if type.is_list else ""
            self._table.report("E105", message, node.span, help)
            return None
        fields = {each.name: each.type for each in record.fields}
        if node.name not in fields:
            what = f"a {record.name} has no field"
            span = tail(node.span, node.name)
            self._table.mistakes.append(unknown("E105", what, node.name, span, fields))
        return fields.get(node.name)

    def _arithmetic(
        self,
        node: syntax.Arithmetic,
        left: Expression,
        right: Expression,
        names: Names,
        expected: TypeName | None,
    ) -> TypeName | None:
        types = [self.value(side, names, expected) for side in (left, right)]
        for side, type in zip((left, right), types, strict=True):
            if type is not None and (type.name not in NUMBER_TYPES or type.is_list):
                message = f"'{node.operator}' takes numbers, and this is {phrase(type)}"
                self._table.report("E204", message, side.span)
                return None
        return self._measure(node, types[0], types[1])

    def _measure(
        self, node: syntax.Arithmetic, left: TypeName | None, right: TypeName | None
    ) -> TypeName | None:
        if left is None or right is None or node.operator in "*/":
            return None  # what a product measures is left to the reader
        if left != right and "number" not in (left.name, right.name):
            message = f"'{node.operator}' cannot join {phrase(left)} with {phrase(right)}"
            self._table.report("E204", message, node.span)
            return None
        return right if left.name == "number" else left

    def _compare(self, node: syntax.Compare, names: Names) -> None:
        left = self.value(node.left, names, None)
        right = self.value(node.right, names, left)
        if left is None or right is None:
            return
        if not (fits(self._table, left, right) or fits(self._table, right, left)):
            message = f"{phrase(left)} is never compared with {phrase(right)}"
            self._table.report("E208", message, node.span)
        elif node.operator in ORDERED and left.name not in NUMBER_TYPES:
            message = f"'{node.operator}' orders numbers, and these are each {phrase(left)}"
            self._table.report("E208", message, node.span)

    # Arguments

    def _predicate(self, atom: syntax.Atom, names: Names) -> syntax.PredicateDeclaration | None:
        declared = self._table.predicates.get(atom.predicate)
        if declared is None:
            self._table.mistakes.append(self._no_predicate(atom))
            return None
        self.arguments(atom, declared.parameters, atom.arguments, names, declared, wild=True)
        return declared

    def _no_predicate(self, atom: syntax.Atom) -> Diagnostic:
        name, span = atom.predicate, head(atom.span, atom.predicate)
        callee = self._table.callable(name)
        if callee is None or nearest(name, self._table.predicates):
            return unknown("E102", "there is no predicate", name, span, self._table.predicates)
        note = Note("declared here", callee.name_span)
        return Diagnostic("E102", f"'{name}' is something to call, not a predicate", span, (note,))

    def call(self, call: syntax.Call, names: Names) -> None:
        """The callee exists and takes these arguments."""
        callee = self.callee(call.callee, head(call.span, call.callee))
        if callee is not None:
            self.arguments(call, callee.parameters, call.arguments, names, callee)

    def callee(
        self, name: str, span: Span
    ) -> syntax.ApiDeclaration | syntax.ProgramDeclaration | None:
        """The program or api of that name; says so where there is none."""
        callee = self._table.callable(name)
        if callee is not None:
            return callee
        predicate = self._table.predicates.get(name)
        if predicate is not None:
            note = Note("declared here", predicate.name_span)
            message = f"'{name}' is a predicate: it can be required or achieved, not called"
            self._table.report("E104", message, span, "", note)
            return None
        known = [*self._table.programs, *self._table.apis]
        self._table.mistakes.append(
            unknown("E104", "no program or api is called", name, span, known)
        )
        return None

    def arguments(
        self,
        node: syntax.Atom | syntax.Call,
        parameters: Sequence[syntax.Parameter],
        arguments: Sequence[Expression],
        names: Names,
        declared: syntax.Declaration,
        wild: bool = False,
    ) -> None:
        """As many as declared, each of its parameter's type and in its range."""
        note = Note(f"'{declared.name}' is declared here", declared.name_span)
        if len(parameters) != len(arguments):
            listing = ", ".join(f"{each.name}: {format_type(each.type)}" for each in parameters)
            message = (
                f"'{declared.name}' takes {_count(len(parameters))}, here are {len(arguments)}"
            )
            span = head(node.span, declared.name)
            self._table.report("E201", message, span, f"{declared.name}({listing})", note)
        for parameter, argument in zip(parameters, arguments, strict=False):
            if not (wild and isinstance(argument, syntax.Wildcard)):
                self._argument(parameter, argument, names, note)

    def _argument(
        self, parameter: syntax.Parameter, argument: Expression, names: Names, note: Note
    ) -> None:
        found = self.value(argument, names, parameter.type)
        if found is None:
            return
        if not fits(self._table, found, parameter.type):
            message = f"'{parameter.name}' is {phrase(parameter.type)}, and this is {phrase(found)}"
            self._table.report("E202", message, argument.span, "", note)
        elif isinstance(argument, syntax.Number):
            value, low, high = map(si, (argument, parameter.low, parameter.high))
            if (
                value is not None
                and low is not None
                and high is not None
                and not low <= value <= high
            ):
                message = f"'{parameter.name}' lies in {low:g} .. {high:g}, and this is {value:g}"
                self._table.report("E203", message, argument.span, "", note)


def _count(number: int) -> str:
    return f"{number} argument{'s' * (number != 1)}"
