"""Where facts are sure, the network decides as the language's rule does."""

from __future__ import annotations

import numpy as np
import torch

from ntp_dsl.core.dispatch.network import batched
from ntp_dsl.core.one_core import load_one_core, shipped_core
from ntp_dsl.core.pretraining.dispatch_data import END, Sample
from ntp_dsl.core.pretraining.nameless_programs import decision, random_program

PROGRAMS, SOAKED = 3000, 40_000  # that were not among those that it learnt from
DIFFERENT = 0.002  # of the decisions, at most


def sure(rng: np.random.Generator) -> Sample | None:
    """Return a decision of a random program over facts that are hardly in doubt, and as they seem."""
    registry = random_program(rng)
    truth = {name: float(rng.random() < 0.5) for name in registry.predicates}
    seen = {name: abs(value - float(rng.uniform(0, 0.05))) for name, value in truth.items()}
    return decision(registry, seen, truth)


def right(sample: Sample, calls: list[float], end: float) -> bool:
    made = calls[: len(sample.row.calls)]
    return (int(np.argmax(made)) if max(made) > end else END) == sample.answer


@torch.inference_mode()
def test_over_sure_facts_the_network_decides_as_the_rule_does(soak: bool) -> None:
    rng, network = np.random.default_rng(2_000_000_011), load_one_core(shipped_core()).dispatch
    drawn = (sure(rng) for _ in range(SOAKED if soak else PROGRAMS))
    samples = [each for each in drawn if each is not None and each.row.calls]
    calls, ends = network(batched([each.row for each in samples]))
    answers = zip(samples, calls.tolist(), ends.tolist(), strict=True)
    assert sum(not right(*each) for each in answers) <= DIFFERENT * len(samples)
