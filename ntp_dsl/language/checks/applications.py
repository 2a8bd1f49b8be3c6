"""Checks of applied predicates and of calls: that they exist, and take the arguments that they are given."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence

from ntp_dsl.language.checks.arguments import ArgumentChecker, Value
from ntp_dsl.language.diagnostics.checked import Checked
from ntp_dsl.language.diagnostics.diagnostics import Diagnostic, Note, unknown
from ntp_dsl.language.diagnostics.spelling import nearest
from ntp_dsl.language.names.signatures import Names, leading_span
from ntp_dsl.language.names.symbol_table import SymbolTable
from ntp_dsl.language.repairs import argument_repairs
from ntp_dsl.language.syntax import nodes
from ntp_dsl.language.syntax.formatter import format_expression
from ntp_dsl.language.syntax.nodes import Expression, Span
from ntp_dsl.language.syntax.visitors import predicates

Applicable = nodes.PredicateDeclaration | nodes.ApiDeclaration | nodes.ProgramDeclaration


class ApplicationChecker:
    """Checks predicates and calls; `value` checks an argument by itself and returns its type."""

    def __init__(self, table: SymbolTable, value: Value) -> None:
        self._table = table
        self._value = value
        self.arguments = ArgumentChecker(table, value)

    def predicate(self, atom: nodes.Atom, names: Names) -> Checked[nodes.PredicateDeclaration | None]:
        """Return the predicate's declaration, if there is one."""
        declared = self._table.predicates.get(atom.predicate)
        if declared is None:
            yield self._no_predicate(atom, names)
            yield from self.arguments.check_alone(atom, names)
            return None
        is_condition = declared.result is None
        yield from self.arguments.check(atom, declared, declared.parameters, names, is_condition)
        return declared

    def _no_predicate(self, atom: nodes.Atom, names: Names) -> Diagnostic:
        name, span = atom.predicate, leading_span(atom.span, atom.predicate)
        callee = self._table.callable(name)
        if (field := argument_repairs.as_field(self.arguments.scope(names), atom)) is not None:
            message = f"there is no predicate '{name}'; it is a field: {field.replacement}"
            return Diagnostic("E102", message, span, fix=field, name=name)
        if callee is None or nearest(name, self._table.predicates):
            likely = self._that_take(self._table.predicates.values(), atom.arguments, names)
            alike = [each for each in self._table.predicates.values() if _are_as_many(each, atom)]
            known = [each.name for each in alike] or [*self._table.predicates]
            return unknown("E102", "there is no predicate", name, span, known, likely=likely)
        note = Note("declared here", callee.name_span)
        message = f"'{name}' is a program or api, not a predicate"
        return Diagnostic("E102", message, span, (note,), _achieved(callee))

    def call(self, call: nodes.Call, names: Names) -> Iterator[Diagnostic]:
        """Check that the callee exists and takes these arguments."""
        callee = self._table.callable(call.callee)
        if callee is not None:
            yield from self.arguments.check(call, callee, callee.parameters, names)
            return
        likely = self._that_take(self._table.callables(), call.arguments, names)
        yield from self.callee(call.callee, leading_span(call.span, call.callee), likely)
        yield from self.arguments.check_alone(call, names)

    def callee(self, name: str, span: Span, likely: Iterable[str] | None = None) -> Iterator[Diagnostic]:
        """Check that something of that name can be called."""
        if self._table.callable(name) is not None:
            return
        predicate = self._table.predicates.get(name)
        known = [*self._table.programs, *self._table.apis]
        if predicate is not None:
            note = Note("declared here", predicate.name_span)
            message = f"'{name}' is a predicate: it can be required or achieved, not called"
            yield Diagnostic("E104", message, span, (note,), self._achievers(name))
            return
        yield unknown("E104", "no program or api is called", name, span, known, likely=likely)

    def _that_take(
        self, declared: Iterable[Applicable], given: Sequence[Expression], names: Names
    ) -> list[str]:
        return [each.name for each in declared if self.arguments.takes(each.parameters, given, names)]

    def _achievers(self, predicate: str) -> str:
        """Say which programs and apis achieve the predicate."""
        callables = self._table.callables()
        names = [c.name for c in callables if c.achieves and predicate in predicates(c.achieves)]
        return f"call what achieves it: {', '.join(names)}" if names else ""


def _are_as_many(declared: nodes.PredicateDeclaration, atom: nodes.Atom) -> bool:
    return len(declared.parameters) == len(atom.arguments)


def _achieved(callee: nodes.ApiDeclaration | nodes.ProgramDeclaration) -> str:
    if callee.achieves is None:
        return ""
    return f"as a condition, write what it achieves: {format_expression(callee.achieves)}"
