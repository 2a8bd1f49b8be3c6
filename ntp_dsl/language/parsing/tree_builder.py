"""From the grammar's rules for declarations to their syntax nodes, in the grammar's order."""

from __future__ import annotations

from dataclasses import dataclass, replace
from inspect import cleandoc
from typing import Any, TypeVar

from ntp_dsl.language.diagnostics.diagnostics import Diagnostic
from ntp_dsl.language.parsing.clause_merging import merge_clauses
from ntp_dsl.language.parsing.term_builder import Terms, Word
from ntp_dsl.language.syntax import nodes
from ntp_dsl.language.syntax.nodes import Expression, Number, Span

T = TypeVar("T")


@dataclass(frozen=True)
class Header:
    """`library NAME` and its docstring."""

    name: str
    docstring: str
    span: Span


@dataclass(frozen=True)
class Clause:
    """One line of a contract or one section of a task."""

    kind: str
    value: object
    span: Span


@dataclass(frozen=True)
class Docstring:
    text: str


@dataclass(frozen=True)
class DrawnFrom:
    """A group of the scene that a sampler draws from."""

    name: Word


@dataclass(frozen=True)
class Calls:
    """What an expert in Python may call."""

    names: tuple[nodes.Name, ...]


Item = nodes.Node | Header | Clause | Docstring | DrawnFrom | Calls | tuple[object, ...] | int


def clean(docstring: str) -> str:
    """Return a docstring's text without its indentation, and without blanks at the ends of lines."""
    return "\n".join(line.rstrip() for line in cleandoc(docstring).split("\n")).strip("\n")


def _text(docstring: Docstring | None) -> str:
    return docstring.text if docstring else ""


UNTOLD = nodes.And(())  # the condition of an `else`, until the `when` before it is known


def _only(kind: type[T], items: tuple[object, ...]) -> tuple[T, ...]:
    return tuple(item for item in items if isinstance(item, kind))


def _in_unit_of(high: Number, low: Number) -> Number:
    """Return the lower bound of `3 .. 12 cm` in the unit that is written once, at the end."""
    return low if low.unit or not high.unit else replace(low, unit=high.unit, is_unit_shared=True)


class Builder(Terms):
    """Builds one declaration; `diagnostics` collects what is wrong beyond the grammar."""

    # Libraries

    def library(self, span: Span, name: Word, docstring: Docstring | None = None) -> Header:
        return Header(name.text, _text(docstring), name.span)

    def use(self, span: Span, library: Word) -> nodes.Use:
        return nodes.Use(library.text, span=library.span)

    # Types, records and constants

    def type(
        self, span: Span, name: Word, parent: nodes.TypeName | None, docstring: Docstring | None
    ) -> nodes.TypeDeclaration:
        return nodes.TypeDeclaration(parent=parent, **self._declared(span, name, docstring))

    def enum(self, span: Span, name: Word, *rest: Word | Docstring | None) -> nodes.EnumDeclaration:
        members = _only(Word, rest)
        return nodes.EnumDeclaration(
            members=tuple(self._declare(member) for member in members),
            member_spans=tuple(member.span for member in members),
            **self._declared(span, name, *_only(Docstring, rest)),
        )

    def record(
        self,
        span: Span,
        name: Word,
        fields: tuple[nodes.Parameter, ...],
        docstring: Docstring | None,
    ) -> nodes.RecordDeclaration:
        return nodes.RecordDeclaration(fields=fields, **self._declared(span, name, docstring))

    def constant(
        self, span: Span, name: Word, type: nodes.TypeName, docstring: Docstring | None
    ) -> nodes.ConstantDeclaration:
        return nodes.ConstantDeclaration(type=type, **self._declared(span, name, docstring))

    # Predicates

    def predicate(
        self,
        span: Span,
        name: Word,
        parameters: tuple[nodes.Parameter, ...],
        result: nodes.TypeName | None,
        by: nodes.Name | None,
        docstring: Docstring | None,
    ) -> nodes.PredicateDeclaration:
        return nodes.PredicateDeclaration(
            parameters=parameters, result=result, by=by, **self._declared(span, name, docstring)
        )

    def composition(
        self,
        span: Span,
        name: Word,
        parameters: tuple[nodes.Parameter, ...],
        docstring: Docstring | None,
        body: Expression,
    ) -> nodes.PredicateDeclaration:
        return nodes.PredicateDeclaration(
            parameters=parameters, body=body, **self._declared(span, name, docstring)
        )

    # Apis and programs

    def api(
        self,
        span: Span,
        name: Word,
        parameters: tuple[nodes.Parameter, ...],
        by: nodes.Name | None,
        *rest: object,
    ) -> nodes.ApiDeclaration:
        return nodes.ApiDeclaration(
            parameters=parameters,
            by=by,
            **self._contract(rest),
            **self._declared(span, name, *_only(Docstring, rest)),
        )

    def program(
        self,
        span: Span,
        name: Word,
        parameters: tuple[nodes.Parameter, ...],
        by: nodes.Name | None,
        *rest: object,
    ) -> nodes.ProgramDeclaration:
        return nodes.ProgramDeclaration(
            parameters=parameters,
            by=by,
            calls=tuple(name for calls in _only(Calls, rest) for name in calls.names),
            body=self._with_conditions([item for item in rest if isinstance(item, nodes.Statement)]),
            **self._contract(rest),
            **self._declared(span, name, *_only(Docstring, rest)),
        )

    def provider(self, span: Span, name: Word) -> nodes.Name:
        return self.name(span, name)

    def calls(self, span: Span, *callees: Word) -> Calls:
        return Calls(tuple(nodes.Name(callee.text, span=callee.span) for callee in callees))

    def docstring(self, span: Span, text: Word) -> Docstring:
        return Docstring(clean(text.text[3:-3]))

    def parameters(self, span: Span, *parameters: nodes.Parameter | None) -> tuple[nodes.Parameter, ...]:
        return _only(nodes.Parameter, parameters)

    def parameter(
        self,
        span: Span,
        name: Word,
        type: nodes.TypeName,
        low: Number | None,
        high: Number | None,
    ) -> nodes.Parameter:
        if low and high:
            low = _in_unit_of(high, low)
        return nodes.Parameter(self._declare(name), type, low, high, span=name.span)

    def list_type(self, span: Span, name: Word) -> nodes.TypeName:
        return nodes.TypeName(name.text, is_list=True, span=name.span)

    def type_name(self, span: Span, name: Word) -> nodes.TypeName:
        return nodes.TypeName(name.text, span=name.span)

    def clauses(self, span: Span, *clauses: Clause) -> tuple[Clause, ...]:
        return clauses

    def requires(self, span: Span, condition: Expression) -> Clause:
        return Clause("requires", condition, span)

    def achieves(self, span: Span, condition: Expression) -> Clause:
        return Clause("achieves", condition, span)

    def says(self, span: Span, *texts: nodes.Text) -> Clause:
        return Clause("says", texts, span)

    def statement(self, span: Span, call: nodes.Call) -> nodes.Call:
        return call

    def loop(self, span: Span, generator: nodes.Generator, body: nodes.Statement) -> nodes.For:
        return self._nested(nodes.For(generator, body, span=span), generator, body)

    def when(self, span: Span, condition: Expression, body: nodes.Statement) -> nodes.When:
        return self._nested(nodes.When(condition, body, span=span), condition, body)

    def otherwise(self, span: Span, body: nodes.Statement) -> nodes.When:
        return self._nested(nodes.When(UNTOLD, body, is_else=True, span=span), body)

    def _with_conditions(self, statements: list[nodes.Statement]) -> tuple[nodes.Statement, ...]:
        """Give each `else` the opposite of the condition of the `when` before it."""
        found: list[nodes.Statement] = []
        for statement in statements:
            if isinstance(statement, nodes.When) and statement.is_else:
                before = found[-1] if found else None
                if isinstance(before, nodes.When) and not before.is_else:
                    opposite = nodes.Not(before.condition, span=before.condition.span)
                    statement = replace(statement, condition=opposite)
                else:
                    self._misplaced_else(statement)
            found.append(statement)
        return tuple(found)

    def _misplaced_else(self, statement: nodes.Statement) -> None:
        message = "an 'else' comes right after a 'when', and none is there"
        help = "in a loop, write the opposite: for x in T if not c: call"
        self.diagnostics.append(Diagnostic("E001", message, statement.span, help=help))

    def block(self, span: Span, *statements: nodes.Statement) -> nodes.Statement:
        for extra in statements[1:2]:
            message = "the body of a 'for' or 'when' is one call, and this is a second one"
            help = "write a program of the two and call that; or, if it comes after the loop, indent it less"
            self.diagnostics.append(Diagnostic("E006", message, extra.span, help=help))
        if isinstance(statements[0], nodes.When) and statements[0].is_else:
            self._misplaced_else(statements[0])
        return statements[0]

    def call(self, span: Span, callee: Word, *arguments: Expression | None) -> nodes.Call:
        given = tuple(argument for argument in arguments if argument is not None)
        return self._nested(nodes.Call(callee.text, given, span=span), *given)

    # Tasks

    def task(self, span: Span, name: Word, *rest: object) -> nodes.TaskDeclaration:
        sections = self._once(_only(Clause, rest))
        return nodes.TaskDeclaration(**sections, **self._declared(span, name, *_only(Docstring, rest)))

    def scene(self, span: Span, *groups: nodes.SceneGroup) -> Clause:
        return Clause("scene", groups, span)

    def shared_scene(self, span: Span, task: Word, *own: nodes.SceneGroup | nodes.Varied) -> Clause:
        return Clause("shared", nodes.SharedScene(task.text, own, span=span, task_span=task.span), span)

    def varied(self, span: Span, name: Word, count: int, most: int | None) -> nodes.Varied:
        return nodes.Varied(name.text, count, most, span=span)

    def initially(self, span: Span, *facts: nodes.Atom) -> Clause:
        return Clause("initially", facts, span)

    def absent(self, span: Span, fact: nodes.Atom) -> nodes.Atom:
        message = "what is not listed does not hold at the start: leave it out"
        self.diagnostics.append(Diagnostic("E504", message, span))
        return fact

    def goal(self, span: Span, goal: nodes.Goal) -> Clause:
        return Clause("goal", goal, span)

    def goal_rows(self, span: Span, *rows: nodes.Row) -> Clause:
        return Clause("goal", self.given(span, *rows), span)

    def given(self, span: Span, *parts: nodes.Row | nodes.TypeName | None) -> nodes.GivenGoal:
        result = next(iter(_only(nodes.TypeName, parts)), None)
        return nodes.GivenGoal(_only(nodes.Row, parts), result, span=span)

    def element(self, span: Span, *terms: Expression) -> nodes.Row:
        return nodes.Row(terms, span=span)

    def run(self, span: Span, call: nodes.Call) -> Clause:
        return Clause("run", call, span)

    def success(self, span: Span, condition: Expression) -> Clause:
        return Clause("success", condition, span)

    def group(
        self,
        span: Span,
        name: Word,
        count: int,
        most: int | None,
        type: nodes.TypeName,
        place: Word,
        details: tuple[nodes.Detail, ...] | None,
    ) -> nodes.SceneGroup:
        return nodes.SceneGroup(
            self._declare(name),
            count,
            type,
            place.text,
            most,
            details or (),
            place_span=place.span,
            span=span,
        )

    def single(
        self,
        span: Span,
        name: Word,
        type: nodes.TypeName,
        place: Word,
        details: tuple[nodes.Detail, ...] | None,
    ) -> nodes.SceneGroup:
        return replace(self.group(span, name, 1, None, type, place, details), is_single=True)

    def details(self, span: Span, *details: nodes.Detail) -> tuple[nodes.Detail, ...]:
        return details

    def detail(self, span: Span, name: Word, *settings: nodes.Setting | None) -> nodes.Detail:
        given = tuple(setting for setting in settings if setting is not None)
        return nodes.Detail(name.text, given, span=span)

    def interval(self, span: Span, low: Number, high: Number) -> nodes.Interval:
        return nodes.Interval(_in_unit_of(high, low), high, span=span)

    def text(self, span: Span, quoted: Word) -> nodes.Text:
        return nodes.Text(quoted.text[1:-1], span=quoted.span)

    def sampler(
        self, span: Span, name: Word, *rest: DrawnFrom | nodes.Option | nodes.Node | None
    ) -> nodes.Sampler:
        groups = [drawn.name for drawn in _only(DrawnFrom, rest)]
        return nodes.Sampler(
            name.text,
            tuple(group.text for group in groups),
            _only(nodes.Option, rest),
            next(iter(_only(nodes.TypeName, rest)), None),
            next(iter(_only(nodes.Name, rest)), None),
            group_spans=tuple(group.span for group in groups),
            span=span,
        )

    def drawn_from(self, span: Span, name: Word) -> DrawnFrom:
        return DrawnFrom(name)

    def option(self, span: Span, name: Word, low: int, high: int | None) -> nodes.Option:
        return nodes.Option(name.text, low, low if high is None else high, span=span)

    # What the grammar cannot say

    def _declared(self, span: Span, name: Word, *docstrings: Docstring | None) -> dict[str, Any]:
        return {
            "name": self._declare(name),
            "docstring": "\n\n".join(text for each in docstrings if (text := _text(each))),
            "name_span": name.span,
            "span": span,
        }

    def _contract(self, rest: tuple[object, ...]) -> dict[str, Any]:
        lines = [item for item in rest if isinstance(item, tuple)]
        clauses = _only(Clause, rest) + tuple(each for line in lines for each in line)
        return self._once(_only(Clause, clauses))

    def _once(self, clauses: tuple[Clause, ...]) -> dict[str, Any]:
        found: dict[str, Any] = {}
        for before, clause in zip((None, *clauses), clauses, strict=False):
            if before is not None and clause.kind in found:
                joint = "commas" if clause.kind == "says" else "'and'"
                message = f"'{clause.kind}' appears twice; join what belongs together with {joint}"
                fix = merge_clauses(found[clause.kind], clause.value, before.span, clause.span)
                self.diagnostics.append(Diagnostic("E008", message, clause.span, fix=fix))
            found.setdefault(clause.kind, clause.value)
        return found
