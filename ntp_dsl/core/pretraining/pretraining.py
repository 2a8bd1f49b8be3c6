"""Pretraining of the one core in two stages, and what is needed to go on from a file."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path

import torch
from torch import Tensor

from ntp_dsl.common.decoding import Count, Unreadable, decode
from ntp_dsl.core.dispatch.network import DispatchNetwork
from ntp_dsl.core.perception.grounding import Grounding
from ntp_dsl.core.pretraining.config import PretrainingConfig
from ntp_dsl.core.pretraining.dispatch_data import Sample
from ntp_dsl.core.pretraining.dispatch_loss import samples_loss
from ntp_dsl.core.pretraining.fitting import Fit, Progress, rows_loss
from ntp_dsl.core.pretraining.grounding_data import Parts
from ntp_dsl.core.weights import Weights, read_weights, write_weights
from ntp_dsl.language.diagnostics.diagnostics import NtpError

PARTIAL, VERSION = "ntp-core-in-training", "2"


class Pretraining:
    """A core on its way: the grounding first, then the dispatcher over what it perceives."""

    def __init__(self, config: PretrainingConfig) -> None:
        torch.set_num_threads(1)  # the tensors are too small for more, and the sums come out the same
        torch.manual_seed(config.seed)
        self.config = config
        self.grounding = Fit(Grounding(), config.iterations, config.seed)
        self.dispatch = Fit(DispatchNetwork(), config.dispatch_iterations, config.seed)

    def fit_grounding(self, parts: Parts, progress: Progress) -> None:
        network = self.grounding.network
        networks = (network.pairs, network.grip, network.hover)
        inputs = [torch.from_numpy(part.inputs) for part in parts]
        answers = [torch.from_numpy(part.answers) for part in parts]
        self.grounding.run(rows_loss(networks, inputs, answers), progress)

    def fit_dispatch(
        self, kinds: Sequence[Sequence[Sample]], sequences: Sequence[Sample], progress: Progress
    ) -> None:
        self.dispatch.run(samples_loss(self.dispatch.network, kinds, sequences), progress)

    def save(self, path: Path) -> None:
        """Write what is needed to go on. Raises `OSError`."""
        tensors: dict[str, Tensor] = {}
        for name, fit in self._fits().items():
            tensors |= {f"{name}.{key}": value for key, value in fit.tensors().items()}
        header = {
            "format": PARTIAL,
            "version": VERSION,
            "config": json.dumps(asdict(self.config)),
            "iterations": json.dumps({name: fit.iteration for name, fit in self._fits().items()}),
        }
        write_weights(Weights(tensors, header), path)

    def resume(self, path: Path) -> None:
        """Go on from a file. Raises `NtpError` for another pretraining's, and for what is none."""
        weights = read_weights(path, "ntp pretrain")
        if weights.format != (PARTIAL, VERSION):
            raise NtpError(f"{path}: expected an unfinished core of `ntp pretrain`; found other safetensors")
        try:
            config = decode(weights.header.get("config", ""), PretrainingConfig)
            iterations = decode(weights.header.get("iterations", ""), dict[str, Count])
            if config != self.config:
                raise NtpError(f"{path}: was made with other settings; choose another --out or remove it")
            for name, fit in self._fits().items():
                own = {
                    k.removeprefix(f"{name}."): v for k, v in weights.tensors.items() if k.startswith(name)
                }
                fit.restore(own, iterations[name])
        except (Unreadable, KeyError, ValueError, RuntimeError) as error:
            raise NtpError(f"{path}: is of another version, or damaged; remove it to begin anew") from error

    def _fits(self) -> dict[str, Fit[Grounding] | Fit[DispatchNetwork]]:
        return {"grounding": self.grounding, "dispatch": self.dispatch}
