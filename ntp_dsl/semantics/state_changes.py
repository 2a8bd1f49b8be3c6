"""What apis do to facts that no geometry decides: they set and clear the state literals that they achieve."""

from __future__ import annotations

from collections.abc import Iterator

from ntp_dsl.language.registry import Api, Registry
from ntp_dsl.language.syntax.nodes import Expression
from ntp_dsl.language.syntax.visitors import predicates
from ntp_dsl.semantics.facts import Fact, Literal, bind
from ntp_dsl.semantics.observation import Argument, DeclaredFact
from ntp_dsl.semantics.state import State

Facts = frozenset[DeclaredFact]


def changed_by(api: Api, arguments: tuple[Argument, ...], state: State) -> Facts:
    """Return the facts that hold after an api that achieves what it is to: those before, set and cleared."""
    facts = set(state.observation.facts)
    achieved = state.literals(api.achieves, api.bind(arguments))
    for literal in (part for fact in achieved for part in _state_literals(fact, state)):
        fact = DeclaredFact(literal.predicate, tuple(map(str, literal.arguments)))
        if literal.positive:
            facts.add(fact)
        else:
            facts.discard(fact)
    return frozenset(facts)


def says_of_state(registry: Registry, expression: Expression | None) -> Iterator[bool]:
    """Yield of each predicate in an expression, and in the bodies of those, whether it is of the state."""
    for name in predicates(expression):
        declared = registry.predicates[name]
        if declared.body is not None:
            yield from says_of_state(registry, declared.body)
        else:
            yield declared.is_state


def _state_literals(fact: Fact, state: State) -> Iterator[Literal]:
    """Yield the literals of the state that a fact consists of."""
    if not isinstance(fact, Literal):
        return
    declared = state.registry.predicates[fact.predicate]
    if declared.body is not None:
        scope = bind(declared, fact.arguments)
        for each in state.literals(declared.body, scope, fact.positive):
            yield from _state_literals(each, state)
    elif declared.is_state:
        ways = state.ways(declared, fact.arguments)  # of `not at(truck, any)`, all of them
        yield from [fact] if ways is None else (Literal(fact.predicate, each, fact.positive) for each in ways)
