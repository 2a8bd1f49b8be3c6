"""The facts that a condition states, and whether one fact implies another.

A fact is an `Atom`, its negation, a `Compare`, or an `Or` of such. Loops leave none of their variables:
`EVERY` stands for each element that an `all` speaks of, `any` for the one that a `some` does.
"""

from __future__ import annotations

from collections.abc import Container, Iterable, Iterator, Mapping
from dataclasses import replace

from ntp_dsl.language.names.signatures import si
from ntp_dsl.language.syntax import nodes
from ntp_dsl.language.syntax.nodes import Atom, Compare, Expression, Field, Name, Not, Or

EVERY = Name("*")  # no name in a text
ANY = nodes.Wildcard()
NEGATED = {"==": "!=", "!=": "==", "<": ">=", ">=": "<", ">": "<=", "<=": ">"}
FLIPPED = {"==": "==", "!=": "!=", "<": ">", ">": "<", "<=": ">=", ">=": "<="}
WEAKER = {  # what an operator implies, between the same operands, besides itself
    "==": {"<=", ">="}, "<": {"<=", "!="}, ">": {">=", "!="},
}  # fmt: skip


def facts(condition: Expression | None, holds: bool = True) -> Iterator[Expression]:
    """Yield all facts that are certain where the condition holds (or does not)."""
    match condition:
        case Atom():
            yield condition if holds else Not(condition)
        case Compare():
            yield condition if holds else negated(condition)
        case Not(value):
            yield from facts(value, not holds)
        case nodes.And(values) | Or(values):
            if holds is isinstance(condition, nodes.And):
                for value in values:
                    yield from facts(value, holds)
            else:
                yield Or(tuple(_joined(value, holds) for value in values))
        case nodes.Quantified(count=int()):
            if holds and condition.count:  # some do
                yield from facts(replace(condition, quantifier="some", count=None))
        case nodes.Quantified(quantifier, body, generators):
            every = holds is (quantifier == "all")
            element: Expression = EVERY if every else ANY
            elements = {each.variable: element for each in generators}
            inner = list(facts(body, holds))
            if not every:  # the element that exists also passes the filter
                inner += [fact for each in generators for fact in facts(each.condition)]
            yield from (substitute(fact, elements) for fact in inner)


def _joined(condition: Expression, holds: bool) -> Expression:
    """Return one alternative, as a whole."""
    parts = tuple(facts(condition, holds))
    return parts[0] if len(parts) == 1 else nodes.And(parts)


def negated(fact: Expression) -> Expression:
    """Return the fact that holds where this one does not."""
    if isinstance(fact, Compare):
        return Compare(NEGATED[fact.operator], fact.left, fact.right)
    return fact.value if isinstance(fact, Not) else Not(fact)


def substitute(term: Expression, values: Mapping[str, Expression]) -> Expression:
    """Return the expression with other terms in place of names; a field of `EVERY` is `EVERY` itself."""
    match term:
        case Name(id):
            return values.get(id, term)
        case Field(value, name):
            whole = values.get(value.id, value)
            if isinstance(whole, Name) and whole != EVERY:
                return Field(whole, name)
            return whole if whole in (EVERY, ANY) else EVERY
        case Atom(predicate, arguments):
            return Atom(predicate, tuple(substitute(each, values) for each in arguments))
        case Not(value):
            return Not(substitute(value, values))
        case Compare(_, left, right) | nodes.Arithmetic(_, left, right):
            return replace(term, left=substitute(left, values), right=substitute(right, values))
        case nodes.And(parts) | Or(parts):
            return replace(term, values=tuple(substitute(each, values) for each in parts))
    return term


def bind(parameters: Iterable[nodes.Parameter], arguments: Iterable[Expression]) -> dict[str, Expression]:
    return {each.name: value for each, value in zip(parameters, arguments, strict=False)}


def implies(have: Expression, need: Expression, members: Container[str] = ()) -> bool:
    """Return whether one fact implies the other.

    Args:
        members: of enumerations, each of which differs from every other.
    """
    match have, need:
        case _, Or(values):
            return any(implies(have, each, members) for each in values) or (
                isinstance(have, Or) and all(implies(each, need, members) for each in have.values)
            )
        case _, nodes.And(values):
            return all(implies(have, each, members) for each in values)
        case nodes.And(values), _:
            return any(implies(each, need, members) for each in values)
        case Or(values), _:
            return all(implies(each, need, members) for each in values)
        case Atom(), Atom():
            return _same_atom(have, need)
        case Not(Atom() as left), Not(Atom() as right):
            return _same_atom(left, right)
        case Compare(), Compare():
            return _implies_comparison(have, need, members)
    return False


def _same_atom(have: Atom, need: Atom) -> bool:
    return (
        have.predicate == need.predicate
        and len(have.arguments) == len(need.arguments)
        and all(map(_same_term, have.arguments, need.arguments))
    )


def _same_term(have: Expression, need: Expression) -> bool:
    if have == need or need == ANY or EVERY in (have, need):
        return True
    if isinstance(have, Atom) and isinstance(need, Atom):
        return _same_atom(have, need)
    return False


def value_of(term: Expression) -> float | None:
    """Return the value of a literal, in SI units; None if there are names in it."""
    if isinstance(term, nodes.Number):
        return si(term)
    if isinstance(term, nodes.Arithmetic):
        left, right = value_of(term.left), value_of(term.right)
        if left is None or right is None or (term.operator == "/" and right == 0):
            return None
        return {"+": left + right, "-": left - right, "*": left * right}.get(
            term.operator, left / right if right else None
        )
    return None


def compare_values(left: float, operator: str, right: float) -> bool:
    return {
        "==": left == right, "!=": left != right, "<": left < right,
        "<=": left <= right, ">": left > right, ">=": left >= right,
    }[operator]  # fmt: skip


def normalised(fact: Compare) -> Compare:
    """Return the comparison with a literal, or a bare name, on the right."""
    written = (nodes.Number, nodes.Arithmetic)
    if isinstance(fact.left, written) and not isinstance(fact.right, written):
        return Compare(FLIPPED[fact.operator], fact.right, fact.left, span=fact.span)
    if isinstance(fact.left, Name) and isinstance(fact.right, Atom):
        return Compare(FLIPPED[fact.operator], fact.right, fact.left, span=fact.span)
    return fact


def _implies_comparison(have: Compare, need: Compare, members: Container[str]) -> bool:
    have, need = normalised(have), normalised(need)
    if not _same_term(have.left, need.left):
        return False
    low, high = value_of(have.right), value_of(need.right)
    if low is not None and high is not None:
        return _implies_bound(have.operator, low, need.operator, high)
    if _same_term(have.right, need.right):
        return need.operator == have.operator or need.operator in WEAKER.get(have.operator, ())
    both = [side.id for side in (have.right, need.right) if isinstance(side, Name)]
    differ = len(both) == 2 and all(each in members for each in both)
    return differ and (have.operator, need.operator) == ("==", "!=")


def _implies_bound(have: str, known: float, need: str, wanted: float) -> bool:
    """Return whether one bound implies another: `x < 1` implies `x <= 2`, and `x != 3`."""
    if have == "==":
        return compare_values(known, need, wanted)
    if have == "!=":
        return need == "!=" and known == wanted
    if need == "!=":
        return not compare_values(wanted, have, known)
    if have[0] != need[0]:
        return False
    is_weaker = len(have) > len(need) and known == wanted  # x <= 1 does not imply x < 1
    return not is_weaker and (known <= wanted if have[0] == "<" else known >= wanted)


def contradicts(one: Expression, other: Expression, members: Container[str] = ()) -> bool:
    """Return whether the two cannot hold together, whatever the world is like."""
    unnamed = {ANY, EVERY} & (_terms(one) | _terms(other))  # it may be another object
    if unnamed or isinstance(one, Or) or isinstance(other, Or):
        return False
    return implies(one, negated(other), members)


def _terms(fact: Expression) -> set[Expression]:
    match fact:
        case Atom(_, arguments):
            return set(arguments).union(*map(_terms, arguments))
        case Not(value):
            return _terms(value)
        case Compare(_, left, right) | nodes.Arithmetic(_, left, right):
            return {left, right} | _terms(left) | _terms(right)
        case nodes.And(values) | Or(values):
            return set[Expression]().union(*map(_terms, values))
    return set()
