"""The state of a scene as it is perceived: each fact with its probability; above one half, it holds."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import cached_property
from typing import Any

import numpy as np

from ntp_dsl.core.perception.grounding import Grounding, ground
from ntp_dsl.language.registry import Registry
from ntp_dsl.language.syntax import nodes
from ntp_dsl.language.syntax.visitors import predicates
from ntp_dsl.semantics.facts import Bindings, Condition, Fact, Literal, bind
from ntp_dsl.semantics.graded import GRADED, Graded
from ntp_dsl.semantics.observation import Argument, Observation
from ntp_dsl.semantics.predicates import BUILT_IN
from ntp_dsl.semantics.state import State

SAMPLES = 24  # of where objects may lie

Variant = tuple[float, "Believed"]  # how probable it is, and what holds then


class Believed(State):
    """A moment of whose facts only the probabilities are known.

    Predicates and readings in Python are part of the declaration: they run on the observation.

    Args:
        chances: the probability of each predicate that a network perceives, by name, of this state and the
            predicate's arguments; functions tell others.
    """

    def __init__(
        self, registry: Registry, observation: Observation, chances: Mapping[str, Callable[..., Any]]
    ) -> None:
        super().__init__(registry, observation)
        self._chances = chances
        self._probabilities: dict[Fact, Any] = {}

    def probability(self, fact: Fact) -> Any:
        """Return how probably a fact holds: minima, maxima and complements of the perceived ones.

        They are numbers, or tensors that gradients go through where the grounding yields such.
        """
        known = self._probabilities.get(fact)
        if known is None:
            known = self._probabilities[fact] = self._of_fact(fact)
        return known

    def likely(self, expression: nodes.Expression | None, scope: Bindings) -> Any:
        """Return how probably an expression holds; None surely does."""
        match expression:
            case None:
                return 1.0
            case nodes.Atom(predicate=predicate, arguments=arguments):
                values = tuple(self.value(term, scope) for term in arguments)
                return self.probability(Literal(predicate, values))
            case nodes.Not(value=value):
                return 1 - self.likely(value, scope)
            case nodes.And(values=values):
                return min((self.likely(value, scope) for value in values), default=1.0)
            case nodes.Or(values=values):
                return max((self.likely(value, scope) for value in values), default=0.0)
            case nodes.Quantified(quantifier=quantifier, body=body, generators=generators):
                inner = [self.likely(body, each) for each in self.scopes(generators, scope)]
                if expression.count is not None:
                    return _counted(inner, expression.count, exactly=quantifier == "exactly")
                return min(inner, default=1.0) if quantifier == "all" else max(inner, default=0.0)
        return float(self.true(expression, scope))

    def _of_fact(self, fact: Fact) -> Any:
        if isinstance(fact, Condition):
            return self.likely(fact.expression, fact.scope)
        declared = self.registry.predicates[fact.predicate]
        ways = self.ways(declared, fact.arguments)
        if (forced := self.forced(fact.predicate, fact.arguments)) is not None:
            chance: Any = float(forced)
        elif ways is not None:
            chance = max((self.probability(Literal(fact.predicate, way)) for way in ways), default=0.0)
        elif declared.body is not None:
            chance = self.likely(declared.body, bind(declared, fact.arguments))
        elif (provider := declared.provider) in self._chances:
            chance = self._chances[provider](self, *fact.arguments)
        else:
            chance = float(bool(self.reading(fact.predicate, fact.arguments)))
        return chance if fact.positive else 1 - chance

    def variants(self, facts: Sequence[Fact]) -> list[Variant]:
        """Return the states that are possible, with their probabilities: of what is certain, this one."""
        return [(1.0, self)]

    def _provided(self, declared: nodes.PredicateDeclaration, arguments: tuple[Argument, ...]) -> Any:
        perceived = self._chances.get(declared.provider) if declared.result is None else None
        if perceived is None:
            return super()._provided(declared, arguments)
        return bool(perceived(self, *arguments) > 0.5)


class Perceived(Believed):
    """A moment of which the worlds' own facts are perceived by a network."""

    def __init__(self, registry: Registry, observation: Observation, network: Grounding) -> None:
        super().__init__(registry, observation, GRADED)
        self._network = network

    @cached_property
    def graded(self) -> Graded:
        return ground(self._network, self.observation)

    def variants(self, facts: Sequence[Fact]) -> list[Variant]:
        """Return the states that are possible as far as functions, and no network, tell some of the facts.

        A function says yes or no of what is observed: how sure that is, is how often it says yes when
        the objects are moved about by the standard deviations of their positions.
        """
        if not self.observation.deviations:
            return [(1.0, self)]
        told = [fact for fact in facts if any(map(self._is_told, predicates_of(fact)))]
        if not told:
            return [(1.0, self)]
        alike: dict[tuple[bool, ...], list[Believed]] = {}
        for state in self._moved_about:
            alike.setdefault(tuple(map(state.holds, told)), []).append(state)
        return [(len(states) / SAMPLES, states[0]) for states in alike.values()]

    def _is_told(self, predicate: str) -> bool:
        """Return whether a function tells a predicate, or one that it is composed of."""
        declared = self.registry.predicates.get(predicate)
        if declared is None:
            return False
        provider = declared.provider
        is_own = provider == nodes.PYTHON or (provider in BUILT_IN and provider not in self._chances)
        return is_own or any(map(self._is_told, predicates(declared.body)))

    @cached_property
    def _moved_about(self) -> list[Believed]:
        """Copies of this moment with the objects moved; what the network perceives is kept."""
        seen = self.observation
        rng = np.random.default_rng(0)
        deviations = np.array([seen.deviations.get(name, 0.0) for name in seen.positions])
        offsets = deviations[:, None] * rng.normal(size=(SAMPLES, len(seen.positions), 3))
        drawn = (np.array([*seen.positions.values()]) + offsets).tolist()
        states: list[Believed] = []
        for places in drawn:
            positions = dict(zip(seen.positions, map(tuple, places), strict=True))
            state = Perceived(self.registry, replace(seen, positions=positions), self._network)
            state.graded = self.graded
            states.append(state)
        return states


def _counted(chances: Sequence[Any], count: int, exactly: bool) -> Any:
    """Return how probably as many of some facts hold: minima and maxima, as of `all` and `some`."""
    ranked = sorted(chances, key=float, reverse=True)
    enough = 1.0 if count == 0 else ranked[count - 1] if count <= len(ranked) else 0.0
    if not exactly:
        return enough
    one_more = ranked[count] if count < len(ranked) else 0.0
    return min(enough, 1 - one_more)


def predicates_of(fact: Fact) -> set[str]:
    """Return the predicates that a fact applies."""
    return predicates(fact.expression) if isinstance(fact, Condition) else {fact.predicate}
