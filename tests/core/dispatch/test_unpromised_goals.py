"""Programs that achieve what none of their calls promises, as where Python says what is built.

They do what their body says, and end as soon as it holds, whatever else does not; also where much is
required, as of objects that are to be there and in reach.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest
import torch
from test_logic import right

from ntp_dsl.core.dispatch.network import batched
from ntp_dsl.core.one_core import load_one_core, shipped_core
from ntp_dsl.core.pretraining.dispatch_data import END, Sample
from ntp_dsl.core.pretraining.nameless_programs import decision, joined, nameless_library
from ntp_dsl.core.pretraining.nameless_sequences import RESULT, random_sequence
from ntp_dsl.language.registry import Registry
from ntp_dsl.language.syntax import nodes

PROGRAMS, SOAKED = 700, 8000  # that were not among those that it learnt from
DIFFERENT = 0.005  # of the decisions, at most


def requiring(registry: Registry, names: list[str], rng: np.random.Generator) -> Registry:
    """Return a program that requires further facts, and each of its calls half of them."""
    further = [nodes.Atom(name) for name in names]
    apis = {
        name: replace(
            api, requires=joined([*filter(None, [api.requires]), *(f for f in further if rng.random() < 0.5)])
        )
        for name, api in registry.apis.items()
    }
    program = registry.programs["p"]
    predicates = [*registry.predicates, *names]
    return nameless_library(predicates, apis, program.body, joined(further), program.achieves)


def decisions(holds: bool, required: int, count: int) -> Iterator[Sample]:
    """Yield decisions of such programs in any state of the other facts, none of which is in doubt."""
    for number in range(count):
        rng = np.random.default_rng((777, number))
        registry, _ = random_sequence(rng)
        if RESULT in registry.predicates:
            names = [f"r{index}" for index in range(required)]
            true = {name: float(rng.random() < 0.5) for name in registry.predicates}
            true |= {RESULT: float(holds)} | dict.fromkeys(names, 1.0)
            seen = {name: abs(value - float(rng.uniform(0, 0.03))) for name, value in true.items()}
            sample = decision(requiring(registry, names, rng), seen, true)
            if sample is not None and sample.row.calls:
                yield sample


@torch.inference_mode()
def share_that_differs(samples: list[Sample]) -> float:
    calls, ends = load_one_core(shipped_core()).dispatch(batched([each.row for each in samples]))
    return 1 - float(np.mean([*map(right, samples, calls.tolist(), ends.tolist())]))


@pytest.mark.parametrize("required", [0, 3, 6])
def test_they_end_as_soon_as_it_holds(required: int, soak: bool) -> None:
    samples = [*decisions(True, required, SOAKED if soak else PROGRAMS)]
    assert sum(each.answer == END for each in samples) > 50
    assert share_that_differs(samples) <= DIFFERENT


@pytest.mark.parametrize("required", [0, 3, 6])
def test_they_do_what_is_left_of_their_body_until_then(required: int, soak: bool) -> None:
    samples = [*decisions(False, required, SOAKED if soak else PROGRAMS)]
    assert sum(each.answer != END for each in samples) > 100
    assert share_that_differs(samples) <= DIFFERENT
