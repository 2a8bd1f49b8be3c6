"""What a program's contract says of the elements of its lists: that alone is what a demonstration shows."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

from ntp_dsl.language.logic.facts import bind, substitute
from ntp_dsl.language.syntax import nodes
from ntp_dsl.language.syntax.nodes import Expression, PredicateDeclaration
from ntp_dsl.language.syntax.visitors import conjuncts, free_names, walk

UNFOLDED = 8  # predicates in one another

Predicates = Mapping[str, PredicateDeclaration]


def parts_about(name: str, achieves: Expression | None) -> tuple[Expression, ...]:
    """Return the parts of a contract that name a list."""
    parts = conjuncts(achieves) if achieves is not None else ()
    return tuple(part for part in parts if name in free_names(part))


def unfolded(condition: Expression, predicates: Predicates, depth: int = UNFOLDED) -> Iterator[Expression]:
    """Yield what must hold for a condition to, with composed predicates taken apart."""
    for part in conjuncts(condition):
        declared = predicates.get(part.predicate) if isinstance(part, nodes.Atom) else None
        body = declared.body if declared is not None and depth else None
        if body is None or any(isinstance(each, nodes.Quantified) for each in walk(body)):
            yield part  # names in a quantified body cannot be replaced
        else:
            assert isinstance(part, nodes.Atom) and declared is not None
            replaced = substitute(body, bind(declared.parameters, part.arguments))
            yield from unfolded(replaced, predicates, depth - 1)


def conditions(parts: Sequence[Expression], predicates: Predicates) -> Iterator[Expression]:
    """Yield parts of a contract, and their conditions with composed predicates taken apart."""
    for part in parts:
        yield part
        if isinstance(part, nodes.Quantified):
            yield from unfolded(part.body, predicates)


def unmentioned(
    parts: Sequence[Expression], record: str, fields: Sequence[str], predicates: Predicates
) -> list[str]:
    """Return the fields of a list's elements that a contract never mentions.

    Args:
        record: the type of the elements.
    """
    inner = [each for said in conditions(parts, predicates) for each in walk(said)]
    if any(_takes_whole(each, record, predicates) for each in inner):
        return []
    used = {each.name for each in inner if isinstance(each, nodes.Field)}
    return [name for name in fields if name not in used]


def _takes_whole(said: Expression | nodes.Generator, record: str, predicates: Predicates) -> bool:
    """Return whether a predicate that is not taken apart takes elements as a whole."""
    if not isinstance(said, nodes.Atom):
        return False
    declared = predicates.get(said.predicate)
    if declared is None or [*unfolded(said, predicates)] != [said]:
        return False
    return any(each.type.name == record for each in declared.parameters)
