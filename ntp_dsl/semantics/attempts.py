"""How often something has failed in a row: facts that the worlds count, so that all hangs on the state."""

from __future__ import annotations

from collections.abc import Set

from ntp_dsl.language.registry import Registry
from ntp_dsl.semantics.observation import DeclaredFact, Observation

FAILURES = "failures"  # of an object, an api and how often that has failed with it

Facts = frozenset[DeclaredFact]


def reads_failures(registry: Registry) -> bool:
    """Return whether a library asks how often something has failed: then it may."""
    declared = (
        each for each in registry.predicates.values() if each.body is None and each.result is not None
    )
    return any(each.provider == FAILURES for each in declared)


def failures(observation: Observation, item: str) -> float:
    """Return how often in a row an api has failed with an object, of the api where that is most."""
    return max((int(fact.arguments[2]) for fact in _of(observation.facts, {item})), default=0.0)


def after_attempt(facts: Facts, api: str, objects: Set[str], achieved: bool) -> Facts:
    """Return the facts after a call of an api with some objects: counted further, or from the beginning."""
    before = {fact for fact in _of(facts, objects) if fact.arguments[1] == api}
    if achieved:
        return facts - before
    counts = dict.fromkeys(objects, 0) | {fact.arguments[0]: int(fact.arguments[2]) for fact in before}
    return facts - before | {
        DeclaredFact(FAILURES, (item, api, str(count + 1))) for item, count in counts.items()
    }


def without_attempts(facts: Facts) -> Facts:
    """Return the facts that say something of the scene."""
    return frozenset(fact for fact in facts if fact.predicate != FAILURES)


def _of(facts: Facts, objects: Set[str]) -> list[DeclaredFact]:
    return [fact for fact in facts if fact.predicate == FAILURES and fact.arguments[0] in objects]
