"""The loss of the dispatch network: how improbable the right call, or the end, is to it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import torch
from torch import Tensor

from ntp_dsl.core.dispatch.network import LEAST, DispatchNetwork, batched
from ntp_dsl.core.pretraining.dispatch_data import END, Sample
from ntp_dsl.core.pretraining.fitting import Loss

BATCH = 32  # of each kind
SEQUENCES = 16  # of a batch: they take more rounds
SHARE = 1 / 3  # of the loss, for sequences


def samples_loss(
    network: DispatchNetwork, kinds: Sequence[Sequence[Sample]], sequences: Sequence[Sample] = ()
) -> Loss:
    """Return the loss over batches that are drawn from each kind of samples in equal parts.

    Args:
        sequences: samples of calls that follow from one another, which are run by themselves.
    """

    def loss(rng: np.random.Generator) -> Tensor:
        chosen = [each for kind in kinds if kind for each in _drawn(kind, BATCH, rng)]
        value = improbability(network, chosen)
        if not sequences:
            return value
        return (1 - SHARE) * value + SHARE * improbability(network, _drawn(sequences, SEQUENCES, rng))

    return loss


def _drawn(samples: Sequence[Sample], count: int, rng: np.random.Generator) -> list[Sample]:
    return [samples[int(index)] for index in rng.integers(len(samples), size=count)]


def improbability(network: DispatchNetwork, samples: Sequence[Sample]) -> Tensor:
    """Return the mean of minus the logarithm of the probability of what is right."""
    calls, end = network(batched([sample.row for sample in samples]))
    answers = torch.tensor([sample.answer for sample in samples])
    made = calls.gather(1, answers.clamp(min=0)[:, None])[:, 0]
    return -torch.where(answers == END, end, made).clamp(min=LEAST).mean()
