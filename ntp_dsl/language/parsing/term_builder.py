"""From the grammar's rules for conditions and values to their syntax nodes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeVar

from ntp_dsl.language.diagnostics.diagnostics import Diagnostic
from ntp_dsl.language.syntax import nodes
from ntp_dsl.language.syntax.nodes import Expression, Number, Span

# Words that open or join an expression; an object of that name could not be referred to.
RESERVED = frozenset("all some exactly any not and or for if when else requires achieves calls".split())
MAX_DEPTH = 60  # of nested expressions: far more than anybody reads, well within Python's stack
MAX_NUMBER = 1e9  # as written; counts and lengths are far below


T = TypeVar("T")


@dataclass(frozen=True)
class Word:
    """A name, a number or an operator as written, with its place."""

    text: str
    span: Span


class Terms:
    """One method a rule; `diagnostics` collects what is wrong beyond the grammar."""

    def __init__(self) -> None:
        self.diagnostics: list[Diagnostic] = []
        self._depths: dict[int, int] = {}  # of the nodes built so far, by identity

    def disjunction(self, span: Span, *values: Expression) -> nodes.Or:
        return self._nested(nodes.Or(values, span=span), *values)

    def conjunction(self, span: Span, *values: Expression) -> nodes.And:
        return self._nested(nodes.And(values, span=span), *values)

    def negation(self, span: Span, value: Expression) -> nodes.Not:
        return self._nested(nodes.Not(value, span=span), value)

    def all(self, span: Span, body: Expression, *generators: nodes.Generator) -> nodes.Quantified:
        return self._nested(nodes.Quantified("all", body, generators, span=span), body, *generators)

    def some(self, span: Span, body: Expression, *generators: nodes.Generator) -> nodes.Quantified:
        return self._nested(nodes.Quantified("some", body, generators, span=span), body, *generators)

    def exactly(
        self, span: Span, count: int, body: Expression, *generators: nodes.Generator
    ) -> nodes.Quantified:
        return self._counted("exactly", span, count, body, generators)

    def at_least(
        self, span: Span, count: int, body: Expression, *generators: nodes.Generator
    ) -> nodes.Quantified:
        return self._counted("at least", span, count, body, generators)

    def _counted(
        self, word: str, span: Span, count: int, body: Expression, generators: tuple[nodes.Generator, ...]
    ) -> nodes.Quantified:
        return self._nested(nodes.Quantified(word, body, generators, count, span=span), body, *generators)

    def generator(
        self, span: Span, variable: Word, iterable: Word, condition: Expression | None
    ) -> nodes.Generator:
        domain = nodes.Name(iterable.text, span=iterable.span)
        node = nodes.Generator(self._declare(variable), domain, condition, span=variable.span)
        return self._nested(node, *([condition] if condition else []))

    def comparison(self, span: Span, left: Expression, operator: Word, right: Expression) -> nodes.Compare:
        return self._nested(nodes.Compare(operator.text, left, right, span=span), left, right)

    def sum(self, span: Span, left: Expression, operator: Word, right: Expression) -> nodes.Arithmetic:
        return self._nested(nodes.Arithmetic(operator.text, left, right, span=span), left, right)

    product = sum

    def number(self, span: Span, minus: Word | None, digits: Word, unit: Word | None) -> Number:
        value = self._value(digits)
        return Number(-value if minus and value else value, unit.text if unit else "", span=span)

    def count(self, span: Span, digits: Word) -> int:
        value = self._value(digits)
        if value != int(value):
            self.diagnostics.append(
                Diagnostic("E007", f"a whole number belongs here, not {digits.text}", digits.span)
            )
        return int(value)

    def negative(self, span: Span, minus: Word, value: Expression) -> nodes.Arithmetic:
        return self._nested(nodes.Arithmetic("-", nodes.ZERO, value, span=span), value)

    def wildcard(self, span: Span) -> nodes.Wildcard:
        return nodes.Wildcard(span=span)

    def name(self, span: Span, name: Word) -> nodes.Name:
        return nodes.Name(name.text, span=span)

    def field(self, span: Span, value: Word, name: Word) -> nodes.Field:
        return nodes.Field(nodes.Name(value.text, span=value.span), name.text, span=span)

    def atom(self, span: Span, predicate: Word, *arguments: Expression | None) -> nodes.Atom:
        given = tuple(argument for argument in arguments if argument is not None)
        return self._nested(nodes.Atom(predicate.text, given, span=span), *given)

    # What the grammar cannot say

    def _declare(self, name: Word) -> str:
        if name.text in RESERVED:
            message = f"'{name.text}' is a keyword, which cannot be used as a name"
            self.diagnostics.append(Diagnostic("E009", message, name.span))
        return name.text

    def _value(self, digits: Word) -> float:
        value = float(digits.text)
        if value > MAX_NUMBER:
            self.diagnostics.append(Diagnostic("E007", "this number is too large", digits.span))
            return 0.0
        return value

    def _nested(self, node: T, *children: object) -> T:
        depth = 1 + max((self._depths.get(id(child), 0) for child in children), default=0)
        self._depths[id(node)] = depth
        if depth == MAX_DEPTH:
            assert isinstance(node, nodes.Node)
            message = "this is nested too deeply to be read; give its parts names of their own"
            self.diagnostics.append(Diagnostic("E010", message, node.span))
        return node
