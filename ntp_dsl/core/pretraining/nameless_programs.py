"""Nameless random programs over random facts, of which only probabilities are known: no world, no library."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np

from ntp_dsl.core.perception.perceived import Believed
from ntp_dsl.core.pretraining.dispatch_data import Sample, sample_of
from ntp_dsl.language.registry import Api, Program, Registry
from ntp_dsl.language.syntax import nodes
from ntp_dsl.policies.expert import Expert
from ntp_dsl.semantics.observation import Observation

NOWHERE = Observation((), {}, (0.0, 0.0, 0.0), closed=False)
GUARDED = 0.25  # of the statements
NEGATIVE = 0.25  # of the literals
DOUBTFUL = 0.3  # of the facts
UNPROMISED = 0.25  # of the programs: they achieve what none of their calls says that it brings about


def nameless(rng: np.random.Generator) -> Sample | None:
    """Return a decision of a random program: what is right by the truth, told by probabilities alone."""
    registry = random_program(rng)
    likely = {name: float(rng.random() < 0.5) for name in registry.predicates}
    return decision(registry, *doubted(likely, DOUBTFUL, rng))


def doubted(
    likely: Mapping[str, float], doubtful: float, rng: np.random.Generator
) -> tuple[dict[str, float], dict[str, float]]:
    """Return how probable facts are said to be, and whether they hold, as often as that says.

    Args:
        likely: 1 for facts that hold as far as is known, else 0.
        doubtful: the share of facts of which nothing is known.
    """
    probabilities = {
        name: float(rng.random()) if rng.random() < doubtful else abs(value - float(rng.uniform(0, 0.05)))
        for name, value in likely.items()
    }
    return probabilities, {name: float(rng.random() < p) for name, p in probabilities.items()}


def decision(
    registry: Registry, probabilities: Mapping[str, float], truth: Mapping[str, float]
) -> Sample | None:
    """Return the decision of a random program; None where its row does not tell it.

    Args:
        probabilities: of the facts, by name, as they are perceived.
        truth: of the same facts: 1 where they hold, else 0.
    """
    seen, true = (believed(registry, each) for each in (probabilities, truth))
    return sample_of(Expert(registry), "p", (), seen, true)


def believed(registry: Registry, probabilities: Mapping[str, float]) -> Believed:
    """Return a moment in which facts are as probable as is said."""
    return Believed(registry, NOWHERE, {name: _constant(value) for name, value in probabilities.items()})


def _constant(value: float) -> Callable[[Believed], float]:
    return lambda _: value


def random_program(rng: np.random.Generator) -> Registry:
    """Return a library of one program, called `p`, over random facts and apis."""
    names = [f"f{index}" for index in range(int(rng.integers(4, 13)))]
    apis = {}
    for index in range(int(rng.integers(1, 8))):
        provided = _literals(names, rng, 1, 2)
        apis[f"c{index}"] = Api(f"c{index}", (), _literals(names, rng, 0, 3), provided, "")
    statements = tuple(_statement(name, names, rng) for name in apis)
    promised = [each.achieves for each in apis.values() if each.achieves is not None and rng.random() < 0.5]
    achieves = joined(promised[:3]) or _literals(names, rng, 1, 2)
    brought = {name for each in apis.values() for name in _names_in(each.achieves)}
    silent = [name for name in names if name not in brought]
    if silent and rng.random() < UNPROMISED:
        achieves = joined([each for each in (_literals(silent, rng, 1, 1), joined(promised[:1])) if each])
    return nameless_library(names, apis, statements, _literals(names, rng, 0, 1), achieves)


def nameless_library(
    names: Sequence[str],
    apis: dict[str, Api],
    body: tuple[nodes.Statement, ...],
    requires: nodes.Expression | None,
    achieves: nodes.Expression | None,
) -> Registry:
    """Return a library of facts, apis, and one program, called `p`."""
    program = Program("p", (), requires, achieves, "", body=body, callees=tuple(apis))
    predicates = {name: nodes.PredicateDeclaration(name) for name in names}
    return Registry("nameless", {}, {}, {}, {}, predicates, apis, {"p": program}, {})


def _names_in(condition: nodes.Expression | None) -> set[str]:
    """Return the names of a conjunction of literals."""
    parts = condition.values if isinstance(condition, nodes.And) else (condition,)
    atoms = [each.value if isinstance(each, nodes.Not) else each for each in parts]
    return {each.predicate for each in atoms if isinstance(each, nodes.Atom)}


def _statement(name: str, names: Sequence[str], rng: np.random.Generator) -> nodes.Statement:
    call = nodes.Call(name)
    if rng.random() >= GUARDED:
        return call
    condition = _literals(names, rng, 1, 1)
    assert condition is not None
    return nodes.When(condition, call)


def _literals(
    names: Sequence[str], rng: np.random.Generator, least: int, most: int
) -> nodes.Expression | None:
    chosen = rng.choice(names, size=int(rng.integers(least, most + 1)), replace=False)
    atoms: list[nodes.Expression] = [nodes.Atom(str(name)) for name in chosen]
    return joined([nodes.Not(atom) if rng.random() < NEGATIVE else atom for atom in atoms])


def joined(conditions: Sequence[nodes.Expression]) -> nodes.Expression | None:
    """Return the conjunction of conditions; None of none."""
    if len(conditions) <= 1:
        return conditions[0] if conditions else None
    parts = [each.values if isinstance(each, nodes.And) else (each,) for each in conditions]
    return nodes.And(tuple(part for each in parts for part in each))
