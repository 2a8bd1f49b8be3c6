"""Fitting small networks to rows of inputs and answers: resumable, and bit-identical for a seed."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import cos, pi
from typing import Generic, TypeVar

import numpy as np
import torch
from torch import Tensor, nn

from ntp_dsl.common.signals import deferred

BATCH = 512
LEARNING_RATE = 3e-3
WARM_UP = 200  # iterations
CLIP = 1.0

Loss = Callable[[np.random.Generator], Tensor]  # of a batch that is drawn
Progress = Callable[[int, float], None]


Network = TypeVar("Network", bound=nn.Module)


@dataclass
class Fit(Generic[Network]):
    """A network on its way, its optimiser, and how many iterations it has had."""

    network: Network
    iterations: int
    seed: int
    iteration: int = 0

    def __post_init__(self) -> None:
        self.optimiser = torch.optim.AdamW(self.network.parameters(), lr=LEARNING_RATE, weight_decay=1e-4)

    def run(self, loss: Loss, progress: Progress = lambda *_: None) -> None:
        """Go on to the last iteration. Each draws by its own seed: a resumed run repeats the whole."""
        self.network.train()
        while self.iteration < self.iterations:
            with deferred():  # so that what is saved is of whole iterations
                value = self._step(loss)
            progress(self.iteration, value)
        self.network.eval()

    def _step(self, loss: Loss) -> float:
        for group in self.optimiser.param_groups:
            group["lr"] = LEARNING_RATE * self._schedule()
        value = loss(np.random.default_rng((self.seed, self.iteration)))
        self.optimiser.zero_grad(set_to_none=True)
        torch.autograd.backward(value)
        nn.utils.clip_grad_norm_(self.network.parameters(), CLIP)
        self.optimiser.step()
        self.iteration += 1
        return float(value.detach())

    @property
    def is_done(self) -> bool:
        return self.iteration >= self.iterations

    def _schedule(self) -> float:
        """Return the warm-up, then half a cosine down to nothing."""
        if self.iteration < WARM_UP:
            return (self.iteration + 1) / WARM_UP
        share = (self.iteration - WARM_UP) / max(1, self.iterations - WARM_UP)
        return 0.5 * (1 + cos(pi * min(1.0, share)))

    def tensors(self) -> dict[str, Tensor]:
        """Return the weights and the optimiser's state, by name."""
        found = {f"network.{name}": value for name, value in self.network.state_dict().items()}
        for number, state in self.optimiser.state_dict()["state"].items():
            found |= {f"optimiser.{number}.{name}": value for name, value in state.items()}
        return found

    def restore(self, tensors: dict[str, Tensor], iteration: int) -> None:
        """Go on from what `tensors` gave at an iteration. Raises `ValueError` or `RuntimeError` else."""
        if not 0 <= iteration <= self.iterations:
            raise ValueError(f"iteration {iteration} of {self.iterations}")
        weights = {n.removeprefix("network."): t for n, t in tensors.items() if n.startswith("network.")}
        self.network.load_state_dict(weights)
        state: dict[int, dict[str, Tensor]] = {}
        for name, value in tensors.items():
            if name.startswith("optimiser."):
                _, number, key = name.split(".", 2)
                state.setdefault(int(number), {})[key] = value
        sizes = [parameter.shape for parameter in self.network.parameters()]
        if iteration and sorted(state) != list(range(len(sizes))):
            raise ValueError("the optimiser's state is not whole")
        for index, found in state.items():
            if found.keys() != {"step", "exp_avg", "exp_avg_sq"} or found["exp_avg"].shape != sizes[index]:
                raise ValueError("the optimiser's state is of another network")
        groups = self.optimiser.state_dict()["param_groups"]
        self.optimiser.load_state_dict({"state": state, "param_groups": groups})
        self.iteration = iteration


def rows_loss(networks: Sequence[nn.Module], inputs: Sequence[Tensor], answers: Sequence[Tensor]) -> Loss:
    """Return the cross-entropy over batches of rows, summed over networks; NaN is no answer."""

    def loss(rng: np.random.Generator) -> Tensor:
        total = torch.zeros(())
        for network, given, right in zip(networks, inputs, answers, strict=True):
            chosen = torch.from_numpy(rng.integers(len(given), size=BATCH))
            logits, wanted = network(given[chosen]), right[chosen]
            asked = ~torch.isnan(wanted)
            total = total + nn.functional.binary_cross_entropy_with_logits(logits[asked], wanted[asked])
        return total

    return loss
