"""From the grammar's rules for conditions and values to their syntax nodes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeVar

from ntp_dsl.language import syntax
from ntp_dsl.language.diagnostics import Diagnostic
from ntp_dsl.language.syntax import Expression, Number, Span

# Words that open or join an expression; a thing of that name could never be mentioned.
RESERVED = frozenset("all some any not and or for if when requires achieves calls".split())
MAX_DEPTH = (
    60  # of nested expressions: far beyond what anybody reads, well within Python's own stack
)
MAX_NUMBER = 1e9  # as written; counts and metres alike stay far below


T = TypeVar("T")


@dataclass(frozen=True)
class Word:
    """A name, a number or an operator as it stands in the text."""

    text: str
    span: Span


class Terms:
    """One method a rule; what is wrong beyond the grammar is left in `mistakes`."""

    def __init__(self) -> None:
        self.mistakes: list[Diagnostic] = []
        self._depths: dict[int, int] = {}  # of the nodes built so far, by identity

    def disjunction(self, span: Span, *values: Expression) -> syntax.Or:
        return self._nested(syntax.Or(values, span=span), *values)

    def conjunction(self, span: Span, *values: Expression) -> syntax.And:
        return self._nested(syntax.And(values, span=span), *values)

    def negation(self, span: Span, value: Expression) -> syntax.Not:
        return self._nested(syntax.Not(value, span=span), value)

    def all(self, span: Span, body: Expression, *generators: syntax.Generator) -> syntax.Quantified:
        return self._nested(
            syntax.Quantified("all", body, generators, span=span), body, *generators
        )

    def some(
        self, span: Span, body: Expression, *generators: syntax.Generator
    ) -> syntax.Quantified:
        return self._nested(
            syntax.Quantified("some", body, generators, span=span), body, *generators
        )

    def generator(
        self, span: Span, variable: Word, iterable: Word, condition: Expression | None
    ) -> syntax.Generator:
        domain = syntax.Name(iterable.text, span=iterable.span)
        node = syntax.Generator(self._declare(variable), domain, condition, span=variable.span)
        return self._nested(node, *([condition] if condition else []))

    def comparison(
        self, span: Span, left: Expression, operator: Word, right: Expression
    ) -> syntax.Compare:
        return self._nested(syntax.Compare(operator.text, left, right, span=span), left, right)

    def sum(
        self, span: Span, left: Expression, operator: Word, right: Expression
    ) -> syntax.Arithmetic:
        return self._nested(syntax.Arithmetic(operator.text, left, right, span=span), left, right)

    product = sum

    def number(self, span: Span, minus: Word | None, digits: Word, unit: Word | None) -> Number:
        value = self._value(digits)
        return Number(-value if minus and value else value, unit.text if unit else "", span=span)

    def wildcard(self, span: Span) -> syntax.Wildcard:
        return syntax.Wildcard(span=span)

    def name(self, span: Span, name: Word) -> syntax.Name:
        return syntax.Name(name.text, span=span)

    def field(self, span: Span, value: Word, name: Word) -> syntax.Field:
        return syntax.Field(syntax.Name(value.text, span=value.span), name.text, span=span)

    def atom(self, span: Span, predicate: Word, *arguments: Expression | None) -> syntax.Atom:
        given = tuple(argument for argument in arguments if argument is not None)
        return self._nested(syntax.Atom(predicate.text, given, span=span), *given)

    # What the grammar cannot say

    def _declare(self, name: Word) -> str:
        if name.text in RESERVED:
            message = f"'{name.text}' is a word of the language; nothing else can be called that"
            self.mistakes.append(Diagnostic("E009", message, name.span))
        return name.text

    def _value(self, digits: Word) -> float:
        value = float(digits.text)
        if value > MAX_NUMBER:
            self.mistakes.append(Diagnostic("E007", "this number is too large", digits.span))
            return 0.0
        return value

    def _nested(self, node: T, *children: object) -> T:
        depth = 1 + max((self._depths.get(id(child), 0) for child in children), default=0)
        self._depths[id(node)] = depth
        if depth == MAX_DEPTH:
            assert isinstance(node, syntax.Node)
            message = "this is nested too deeply to be read; give its parts names of their own"
            self.mistakes.append(Diagnostic("E010", message, node.span))
        return node
