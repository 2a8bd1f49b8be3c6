"""What apis do to facts that no geometry decides: they set and clear the state literals that they achieve."""

from __future__ import annotations

from collections.abc import Iterator

from ntp_dsl.language.registry import Api, Registry
from ntp_dsl.language.syntax.nodes import STATE, Expression
from ntp_dsl.language.syntax.visitors import predicates
from ntp_dsl.semantics.observation import Argument, DeclaredFact
from ntp_dsl.semantics.state import Fact, Literal, State, provider_of

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


def providers(registry: Registry, expression: Expression | None) -> Iterator[str]:
    """Yield what decides each predicate of an expression, and of the bodies of those."""
    for name in predicates(expression):
        declared = registry.predicates[name]
        if declared.body is not None:
            yield from providers(registry, declared.body)
        else:
            yield provider_of(declared)


def _state_literals(fact: Fact, state: State) -> Iterator[Literal]:
    """Yield the literals of the state that a fact consists of."""
    if not isinstance(fact, Literal):
        return
    declared = state.registry.predicates[fact.predicate]
    if declared.body is not None:
        names = (parameter.name for parameter in declared.parameters)
        scope = dict(zip(names, fact.arguments, strict=True))
        for each in state.literals(declared.body, scope, fact.positive):
            yield from _state_literals(each, state)
    elif provider_of(declared) == STATE:
        yield fact
