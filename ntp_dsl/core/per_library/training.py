"""Training: AdamW over batches of a corpus, resumable at every checkpoint, bit-identical for a seed."""

from __future__ import annotations

from collections.abc import Callable
from math import cos, pi

import numpy as np
import torch

from ntp_dsl.core.per_library.config import CoreConfig, TrainingConfig
from ntp_dsl.core.per_library.corpus import Corpus
from ntp_dsl.core.per_library.losses import loss
from ntp_dsl.core.per_library.memory import Memory
from ntp_dsl.core.per_library.model import Core

Progress = Callable[[int, dict[str, float]], None]


def use_threads(count: int) -> None:
    """Of the processor, for all that a core computes; the tensors are too small for many to help."""
    torch.set_num_threads(count)


class Trainer:
    """A core, its optimiser, and how many iterations it has had."""

    def __init__(self, core_config: CoreConfig, config: TrainingConfig, memory: Memory) -> None:
        torch.manual_seed(config.seed)
        self.config = config
        self.core = Core(core_config, memory)
        self.optimiser = torch.optim.AdamW(
            self.core.parameters(), lr=config.learning_rate, weight_decay=config.weight_decay
        )
        self.iteration = 0

    def run(self, corpus: Corpus, progress: Progress = lambda *_: None) -> Core:
        """To the last iteration. Each draws by its own seed, so that a resumed run repeats the whole."""
        self.core.train()
        while self.iteration < self.config.iterations:
            parts = self.step(corpus)
            self.iteration += 1
            progress(self.iteration, parts)
        return self.core.eval()

    def step(self, corpus: Corpus) -> dict[str, float]:
        for group in self.optimiser.param_groups:
            group["lr"] = self.config.learning_rate * self._schedule()
        rng = np.random.default_rng((self.config.seed, self.iteration))
        self.optimiser.zero_grad(set_to_none=True)
        shown: dict[str, float] = {}
        total = torch.zeros(())
        for frames, states, right in corpus.batches(self.config, len(self.core.reader.hops), rng):
            for name, part in loss(self.core, frames, states, right).items():
                total = total + part
                shown[name] = shown.get(name, 0.0) + float(part.detach())
        torch.autograd.backward(total)
        torch.nn.utils.clip_grad_norm_(self.core.parameters(), self.config.clip)
        self.optimiser.step()
        return shown

    def _schedule(self) -> float:
        """Warm-up, then half a cosine down to nothing."""
        if self.iteration < self.config.warm_up:
            return (self.iteration + 1) / self.config.warm_up
        span = max(1, self.config.iterations - self.config.warm_up)
        return 0.5 * (1 + cos(pi * (self.iteration - self.config.warm_up) / span))
