"""From the grammar's rules for declarations to their syntax nodes, in the grammar's order."""

from __future__ import annotations

from dataclasses import dataclass
from inspect import cleandoc
from typing import Any, TypeVar

from ntp_dsl.language import syntax
from ntp_dsl.language.build_clauses import join_clauses
from ntp_dsl.language.build_terms import Terms, Word
from ntp_dsl.language.diagnostics import Diagnostic
from ntp_dsl.language.syntax import Expression, Number, Span

T = TypeVar("T")


@dataclass(frozen=True)
class Header:
    """`library NAME` and what is said about it."""

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

    names: tuple[syntax.Name, ...]


Item = syntax.Node | Header | Clause | Docstring | DrawnFrom | Calls | tuple[object, ...] | int


def clean(docstring: str) -> str:
    """A docstring's text without its indentation, nor blanks at any line's end."""
    return "\n".join(line.rstrip() for line in cleandoc(docstring).split("\n")).strip("\n")


def _text(docstring: Docstring | None) -> str:
    return docstring.text if docstring else ""


def _only(kind: type[T], items: tuple[object, ...]) -> tuple[T, ...]:
    return tuple(item for item in items if isinstance(item, kind))


class Builder(Terms):
    """Builds one declaration; what is wrong beyond the grammar is left in `mistakes`."""

    # Libraries

    def library(self, span: Span, name: Word, docstring: Docstring | None = None) -> Header:
        return Header(name.text, _text(docstring), name.span)

    def use(self, span: Span, library: Word) -> syntax.Use:
        return syntax.Use(library.text, span=library.span)

    # What there is

    def type(
        self, span: Span, name: Word, parent: syntax.TypeName | None, docstring: Docstring | None
    ) -> syntax.TypeDeclaration:
        return syntax.TypeDeclaration(parent=parent, **self._declared(span, name, docstring))

    def enum(
        self, span: Span, name: Word, *rest: Word | Docstring | None
    ) -> syntax.EnumDeclaration:
        members = _only(Word, rest)
        return syntax.EnumDeclaration(
            members=tuple(self._declare(member) for member in members),
            member_spans=tuple(member.span for member in members),
            **self._declared(span, name, *_only(Docstring, rest)),
        )

    def record(
        self,
        span: Span,
        name: Word,
        fields: tuple[syntax.Parameter, ...],
        docstring: Docstring | None,
    ) -> syntax.RecordDeclaration:
        return syntax.RecordDeclaration(fields=fields, **self._declared(span, name, docstring))

    def constant(
        self, span: Span, name: Word, type: syntax.TypeName, docstring: Docstring | None
    ) -> syntax.ConstantDeclaration:
        return syntax.ConstantDeclaration(type=type, **self._declared(span, name, docstring))

    # What can be true

    def predicate(
        self,
        span: Span,
        name: Word,
        parameters: tuple[syntax.Parameter, ...],
        result: syntax.TypeName | None,
        by: syntax.Name | None,
        docstring: Docstring | None,
    ) -> syntax.PredicateDeclaration:
        return syntax.PredicateDeclaration(
            parameters=parameters, result=result, by=by, **self._declared(span, name, docstring)
        )

    def composition(
        self,
        span: Span,
        name: Word,
        parameters: tuple[syntax.Parameter, ...],
        docstring: Docstring | None,
        body: Expression,
    ) -> syntax.PredicateDeclaration:
        return syntax.PredicateDeclaration(
            parameters=parameters, body=body, **self._declared(span, name, docstring)
        )

    # What can be done

    def api(
        self,
        span: Span,
        name: Word,
        parameters: tuple[syntax.Parameter, ...],
        by: syntax.Name | None,
        *rest: object,
    ) -> syntax.ApiDeclaration:
        return syntax.ApiDeclaration(
            parameters=parameters,
            by=by,
            **self._contract(rest),
            **self._declared(span, name, *_only(Docstring, rest)),
        )

    def program(
        self,
        span: Span,
        name: Word,
        parameters: tuple[syntax.Parameter, ...],
        by: syntax.Name | None,
        *rest: object,
    ) -> syntax.ProgramDeclaration:
        return syntax.ProgramDeclaration(
            parameters=parameters,
            by=by,
            calls=tuple(name for calls in _only(Calls, rest) for name in calls.names),
            body=tuple(item for item in rest if isinstance(item, syntax.Statement)),
            **self._contract(rest),
            **self._declared(span, name, *_only(Docstring, rest)),
        )

    def provider(self, span: Span, name: Word) -> syntax.Name:
        return self.name(span, name)

    def calls(self, span: Span, *callees: Word) -> Calls:
        return Calls(tuple(syntax.Name(callee.text, span=callee.span) for callee in callees))

    def docstring(self, span: Span, text: Word) -> Docstring:
        return Docstring(clean(text.text[3:-3]))

    def parameters(
        self, span: Span, *parameters: syntax.Parameter | None
    ) -> tuple[syntax.Parameter, ...]:
        return _only(syntax.Parameter, parameters)

    def parameter(
        self,
        span: Span,
        name: Word,
        type: syntax.TypeName,
        low: Number | None,
        high: Number | None,
    ) -> syntax.Parameter:
        return syntax.Parameter(self._declare(name), type, low, high, span=name.span)

    def list_type(self, span: Span, name: Word) -> syntax.TypeName:
        return syntax.TypeName(name.text, is_list=True, span=name.span)

    def type_name(self, span: Span, name: Word) -> syntax.TypeName:
        return syntax.TypeName(name.text, span=name.span)

    def clauses(self, span: Span, *clauses: Clause) -> tuple[Clause, ...]:
        return clauses

    def requires(self, span: Span, condition: Expression) -> Clause:
        return Clause("requires", condition, span)

    def achieves(self, span: Span, condition: Expression) -> Clause:
        return Clause("achieves", condition, span)

    def statement(self, span: Span, call: syntax.Call) -> syntax.Call:
        return call

    def loop(self, span: Span, generator: syntax.Generator, body: syntax.Statement) -> syntax.For:
        return self._nested(syntax.For(generator, body, span=span), generator, body)

    def when(self, span: Span, condition: Expression, body: syntax.Statement) -> syntax.When:
        return self._nested(syntax.When(condition, body, span=span), condition, body)

    def block(self, span: Span, *statements: syntax.Statement) -> syntax.Statement:
        for extra in statements[1:2]:
            message = "a 'for' or 'when' holds one call; this is another"
            help = "move them into a program of their own, or indent this one less"
            self.mistakes.append(Diagnostic("E006", message, extra.span, help=help))
        return statements[0]

    def call(self, span: Span, callee: Word, *arguments: Expression | None) -> syntax.Call:
        given = tuple(argument for argument in arguments if argument is not None)
        return self._nested(syntax.Call(callee.text, given, span=span), *given)

    # What to try

    def task(self, span: Span, name: Word, *rest: object) -> syntax.TaskDeclaration:
        sections = self._once(_only(Clause, rest))
        return syntax.TaskDeclaration(
            **sections, **self._declared(span, name, *_only(Docstring, rest))
        )

    def scene(self, span: Span, *groups: syntax.SceneGroup) -> Clause:
        return Clause("scene", groups, span)

    def goal(self, span: Span, sampler: syntax.Sampler) -> Clause:
        return Clause("goal", sampler, span)

    def run(self, span: Span, call: syntax.Call) -> Clause:
        return Clause("run", call, span)

    def success(self, span: Span, condition: Expression) -> Clause:
        return Clause("success", condition, span)

    def group(
        self,
        span: Span,
        name: Word,
        count: int,
        most: int | None,
        type: syntax.TypeName,
        place: Word,
        details: tuple[syntax.Detail, ...] | None,
    ) -> syntax.SceneGroup:
        return syntax.SceneGroup(
            self._declare(name),
            count,
            type,
            place.text,
            most,
            details or (),
            place_span=place.span,
            span=span,
        )

    def details(self, span: Span, *details: syntax.Detail) -> tuple[syntax.Detail, ...]:
        return details

    def detail(self, span: Span, name: Word, *settings: syntax.Setting | None) -> syntax.Detail:
        given = tuple(setting for setting in settings if setting is not None)
        return syntax.Detail(name.text, given, span=span)

    def interval(self, span: Span, low: Number, high: Number) -> syntax.Interval:
        return syntax.Interval(low, high, span=span)

    def text(self, span: Span, quoted: Word) -> syntax.Text:
        return syntax.Text(quoted.text[1:-1], span=quoted.span)

    def sampler(
        self, span: Span, name: Word, *rest: DrawnFrom | syntax.Option | syntax.Node | None
    ) -> syntax.Sampler:
        groups = [drawn.name for drawn in _only(DrawnFrom, rest)]
        return syntax.Sampler(
            name.text,
            tuple(group.text for group in groups),
            _only(syntax.Option, rest),
            next(iter(_only(syntax.TypeName, rest)), None),
            next(iter(_only(syntax.Name, rest)), None),
            group_spans=tuple(group.span for group in groups),
            span=span,
        )

    def drawn_from(self, span: Span, name: Word) -> DrawnFrom:
        return DrawnFrom(name)

    def option(self, span: Span, name: Word, low: int, high: int | None) -> syntax.Option:
        return syntax.Option(name.text, low, low if high is None else high, span=span)

    def count(self, span: Span, digits: Word) -> int:
        value = self._value(digits)
        if value != int(value):
            self.mistakes.append(
                Diagnostic("E007", f"a whole number belongs here, not {digits.text}", digits.span)
            )
        return int(value)

    # What the grammar cannot say

    def _declared(
        self, span: Span, name: Word, docstring: Docstring | None = None
    ) -> dict[str, Any]:
        return {
            "name": self._declare(name),
            "docstring": _text(docstring),
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
                message = f"'{clause.kind}' is said twice; join what belongs together with 'and'"
                fix = join_clauses(found[clause.kind], clause.value, before.span, clause.span)
                self.mistakes.append(Diagnostic("E008", message, clause.span, fix=fix))
            found.setdefault(clause.kind, clause.value)
        return found
