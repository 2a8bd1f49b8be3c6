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


def nameless(rng: np.random.Generator) -> Sample | None:
    """Return a decision of a random program: what is right by the truth, told by probabilities alone."""
    registry = random_program(rng)
    likely = {name: float(rng.random() < 0.5) for name in registry.predicates}
    probabilities = {
        name: float(rng.random()) if rng.random() < DOUBTFUL else abs(value - float(rng.uniform(0, 0.05)))
        for name, value in likely.items()
    }
    truth = {name: float(rng.random() < p) for name, p in probabilities.items()}
    return decision(registry, probabilities, truth)


def decision(
    registry: Registry, probabilities: Mapping[str, float], truth: Mapping[str, float]
) -> Sample | None:
    """Return the decision of a random program; None where its row does not tell it.

    Args:
        probabilities: of the facts, by name, as they are perceived.
        truth: of the same facts: 1 where they hold, else 0.
    """
    believed, true = (
        Believed(registry, NOWHERE, {name: _constant(value) for name, value in each.items()})
        for each in (probabilities, truth)
    )
    return sample_of(Expert(registry), "p", (), believed, true)


def _constant(value: float) -> Callable[[], float]:
    return lambda: value


def random_program(rng: np.random.Generator) -> Registry:
    """Return a library of one program, called `p`, over random facts and apis."""
    names = [f"f{index}" for index in range(int(rng.integers(4, 13)))]
    apis = {}
    for index in range(int(rng.integers(1, 8))):
        provided = _literals(names, rng, 1, 2)
        apis[f"c{index}"] = Api(f"c{index}", (), _literals(names, rng, 0, 3), provided, "")
    statements = tuple(_statement(name, names, rng) for name in apis)
    promised = [each.achieves for each in apis.values() if each.achieves is not None and rng.random() < 0.5]
    achieves = _joined(promised[:3]) or _literals(names, rng, 1, 2)
    program = Program(
        "p", (), _literals(names, rng, 0, 1), achieves, "", body=statements, callees=tuple(apis)
    )
    predicates = {name: nodes.PredicateDeclaration(name) for name in names}
    return Registry("nameless", {}, {}, {}, {}, predicates, apis, {"p": program}, {})


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
    return _joined([nodes.Not(atom) if rng.random() < NEGATIVE else atom for atom in atoms])


def _joined(conditions: Sequence[nodes.Expression]) -> nodes.Expression | None:
    if len(conditions) <= 1:
        return conditions[0] if conditions else None
    parts = [each.values if isinstance(each, nodes.And) else (each,) for each in conditions]
    return nodes.And(tuple(part for each in parts for part in each))
