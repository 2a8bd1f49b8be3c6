"""Long sequences of calls, each of which needs what one before it does: as the rule has it, of any length."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest
import torch
from test_logic import right

from ntp_dsl.core.dispatch.network import batched
from ntp_dsl.core.dispatch.rows import unrolled
from ntp_dsl.core.one_core import load_one_core, shipped_core
from ntp_dsl.core.pretraining.dispatch_data import END, Sample
from ntp_dsl.core.pretraining.nameless_programs import believed, decision, nameless_library
from ntp_dsl.core.pretraining.nameless_sequences import random_sequence, way
from ntp_dsl.language.registry import Api, Registry
from ntp_dsl.language.syntax import nodes

LENGTHS = range(1, 19)  # calls: more than any that it learnt from
SEQUENCES, SOAKED = 150, 2000  # that were not among those that it learnt from
DIFFERENT = 0.003  # of the decisions, at most


def chain(length: int) -> Registry:
    """Return a program of calls that each need the one before, of which only the last one is wanted."""
    facts = [nodes.Atom(f"f{number}") for number in range(length)]
    apis = {
        f"c{number}": Api(f"c{number}", (), facts[number - 1] if number else None, fact, "")
        for number, fact in enumerate(facts)
    }
    names = [fact.predicate for fact in facts]
    return nameless_library(names, apis, tuple(map(nodes.Call, apis)), None, facts[-1])


def on_the_way(length: int) -> Iterator[Sample]:
    """Yield the decisions in a chain of which more and more is done."""
    registry = chain(length)
    for done in range(length + 1):
        truth = {f"f{number}": float(number < done) for number in range(length)}
        sample = decision(registry, truth, truth)
        assert sample is not None and sample.answer == (done if done < length else END)
        yield sample


@pytest.mark.parametrize("length", LENGTHS)
@torch.inference_mode()
def test_the_next_call_of_a_sequence_is_made_however_long_it_is(length: int) -> None:
    network, samples = load_one_core(shipped_core()).dispatch, [*on_the_way(length)]
    calls, ends = network(batched([each.row for each in samples]))
    assert all(map(right, samples, calls.tolist(), ends.tolist()))


@torch.inference_mode()
def test_a_short_program_is_decided_beside_long_ones_as_it_is_alone() -> None:
    network = load_one_core(shipped_core()).dispatch
    rows = [sample.row for length in (2, 17, 3, 9) for sample in on_the_way(length)]
    calls, ends = network(batched(rows))
    for number, row in enumerate(rows):
        alone, end = network(batched([row]))
        assert torch.allclose(calls[number, : len(row.calls)], alone[0], atol=1e-4)
        assert torch.allclose(ends[number], end[0], atol=1e-4)


def sure(rng: np.random.Generator) -> Iterator[Sample]:
    """Yield the decisions on the way through a random sequence, over facts that are hardly in doubt."""
    registry, initially = random_sequence(rng)
    for true in way(registry, {name: float(name in initially) for name in registry.predicates}):
        seen = {name: abs(value - float(rng.uniform(0, 0.05))) for name, value in true.items()}
        sample = decision(registry, seen, true)
        if sample is not None and sample.row.calls:
            yield sample


@torch.inference_mode()
def test_random_sequences_are_followed(soak: bool) -> None:
    network = load_one_core(shipped_core()).dispatch
    numbers = range(SOAKED if soak else SEQUENCES)
    samples = [each for number in numbers for each in sure(np.random.default_rng((999, number)))]
    calls, ends = network(batched([each.row for each in samples]))
    wrong = [not right(*each) for each in zip(samples, calls.tolist(), ends.tolist(), strict=True)]
    assert sum(wrong) <= DIFFERENT * len(samples)


def test_a_row_of_a_chain_has_an_edge_from_each_call_to_the_next() -> None:
    registry = chain(5)
    truth = dict.fromkeys(registry.predicates, 0.0)
    row = unrolled(registry.programs["p"], (), believed(registry, truth))
    facts = {call: fact for call, fact in row.provides}
    assert [(call - 1, fact) for call, fact in row.requires] == [(n, facts[n]) for n in range(4)]
