"""Files of weights: safetensors with a description in the header; nothing in them can run."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import torch
from safetensors import SafetensorError, safe_open
from safetensors.torch import save
from torch import Tensor

from ntp_dsl.common.files import written_whole
from ntp_dsl.language.diagnostics.diagnostics import NtpError

Shapes = dict[str, tuple[torch.Size, torch.dtype]]


@dataclass(frozen=True)
class Weights:
    """The contents of a file: tensors by name, and texts by name that describe them."""

    tensors: Mapping[str, Tensor]
    header: Mapping[str, str]

    @property
    def format(self) -> tuple[str, str]:
        """Return what it is a file of, and of which version."""
        return self.header.get("format", ""), self.header.get("version", "")


def write_weights(weights: Weights, path: Path) -> None:
    """Write a file, whole or not at all. Raises `OSError`."""
    with written_whole(path) as partial:
        partial.write_bytes(save(dict(weights.tensors), dict(weights.header)))


def read_weights(path: Path, made_by: str) -> Weights:
    """Read a file. Raises `NtpError` for what is no file of weights, and for weights that are not finite.

    Args:
        made_by: the command that makes such files.
    """
    if not path.is_file():
        raise NtpError(f"{path}: no such checkpoint; `{made_by}` makes them")
    try:
        with safe_open(path, framework="pt") as file:
            header = file.metadata() or {}
            tensors = {name: file.get_tensor(name) for name in file.keys()}  # noqa: SIM118
    except (SafetensorError, OSError, ValueError) as error:
        raise NtpError(
            f"{path}: expected a checkpoint (safetensors), found something else or a truncated file"
        ) from error
    if not all(torch.isfinite(tensor).all() for tensor in tensors.values()):
        raise NtpError(f"{path}: expected finite weights, found NaN or infinity; `{made_by}` makes it anew")
    return Weights(tensors, header)


def shapes(tensors: Mapping[str, Tensor]) -> Shapes:
    return {name: (tensor.shape, tensor.dtype) for name, tensor in tensors.items()}
