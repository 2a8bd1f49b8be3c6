"""The one core: what is learnt once, for every library, and its file."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ntp_dsl.common.decoding import Unreadable, decode
from ntp_dsl.common.resources import checkpoints_folder
from ntp_dsl.core.dispatch.network import DispatchNetwork
from ntp_dsl.core.perception.grounding import Grounding
from ntp_dsl.core.weights import Weights, read_weights, shapes, write_weights
from ntp_dsl.language.diagnostics.diagnostics import NtpError

FORMAT, VERSION = "ntp-core", "1"
MADE_BY = "ntp pretrain"


@dataclass(frozen=True)
class OneCore:
    """What is learnt, and how it came to be."""

    grounding: Grounding
    dispatch: DispatchNetwork
    recipe: Mapping[str, Any]


def shipped_core() -> Path:
    """Return the file of the core that ships with the package."""
    return checkpoints_folder() / "core.safetensors"


def save_one_core(core: OneCore, path: Path) -> None:
    """Write a core, whole or not at all. Raises `OSError`."""
    header = {"format": FORMAT, "version": VERSION, "recipe": json.dumps(core.recipe, default=str)}
    tensors = {
        f"{name}.{key}": value
        for name, network in (("grounding", core.grounding), ("dispatch", core.dispatch))
        for key, value in network.state_dict().items()
    }
    write_weights(Weights(tensors, header), path)


def load_one_core(path: Path) -> OneCore:
    """Read a core. Raises `NtpError`, with what was expected and found, for anything else."""
    return one_core(read_weights(path, MADE_BY), path)


def one_core(weights: Weights, path: Path) -> OneCore:
    """Return the core of a file. Raises `NtpError` for the weights of anything else."""
    if weights.format != (FORMAT, VERSION):
        raise NtpError(f"{path}: expected a core of `{MADE_BY}`, version {VERSION}; found other safetensors")
    try:
        recipe = decode(weights.header.get("recipe", ""), dict[str, Any])
    except Unreadable as error:
        raise NtpError(f"{path}: the core's description is damaged: {error}") from error
    grounding, dispatch = Grounding(), DispatchNetwork()
    for name, network in (("grounding", grounding), ("dispatch", dispatch)):
        own = {
            key.removeprefix(f"{name}."): tensor
            for key, tensor in weights.tensors.items()
            if key.startswith(f"{name}.")
        }
        if shapes(network.state_dict()) != shapes(own):
            raise NtpError(
                f"{path}: the weights do not fit this version of the core; `{MADE_BY}` makes it anew"
            )
        network.load_state_dict(own)
    return OneCore(grounding.eval(), dispatch.eval(), recipe)
