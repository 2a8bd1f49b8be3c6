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


def samples_loss(network: DispatchNetwork, kinds: Sequence[Sequence[Sample]]) -> Loss:
    """Return the loss over batches that are drawn from each kind of samples in equal parts."""

    def loss(rng: np.random.Generator) -> Tensor:
        chosen = [kind[int(index)] for kind in kinds if kind for index in rng.integers(len(kind), size=BATCH)]
        return improbability(network, chosen)

    return loss


def improbability(network: DispatchNetwork, samples: Sequence[Sample]) -> Tensor:
    """Return the mean of minus the logarithm of the probability of what is right."""
    calls, end = network(batched([sample.row for sample in samples]))
    answers = torch.tensor([sample.answer for sample in samples])
    made = calls.gather(1, answers.clamp(min=0)[:, None])[:, 0]
    return -torch.where(answers == END, end, made).clamp(min=LEAST).mean()
