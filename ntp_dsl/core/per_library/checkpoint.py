"""Checkpoints: safetensors, with the memory, the sizes and the exact recipe in the file's own header."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import msgspec
import torch
from msgspec import Struct
from torch import Tensor

from ntp_dsl.common.decoding import Count, Unreadable, decode, decoding
from ntp_dsl.common.text import shortened
from ntp_dsl.core.per_library.config import CoreConfig
from ntp_dsl.core.per_library.memory import Memory
from ntp_dsl.core.per_library.model import Core
from ntp_dsl.core.per_library.training import Trainer
from ntp_dsl.core.weights import Weights, read_weights, shapes, write_weights
from ntp_dsl.language.diagnostics.diagnostics import NtpError
from ntp_dsl.language.registry import Registry

FORMAT = "ntp-checkpoint"
VERSION = "1"
MADE_BY = "ntp train"


@dataclass(frozen=True)
class Checkpoint:
    """A trained core and how it came to be."""

    core: Core
    recipe: Mapping[str, Any]


@dataclass(frozen=True)
class _File:
    """The contents of a file."""

    tensors: Mapping[str, Tensor]
    config: CoreConfig
    memory: Memory
    recipe: dict[str, Any]


class _Progress(Struct, frozen=True):
    """The recipe of a training that is not finished."""

    iteration: Count
    training: dict[str, Any]  # as of `TrainingConfig`
    data: Any = None


def save_core(core: Core, recipe: Mapping[str, Any], path: Path) -> None:
    """Write a checkpoint, whole or not at all. Raises `OSError`."""
    _write(core.state_dict(), core, recipe, path)


def load_core(path: Path) -> Checkpoint:
    """Read a checkpoint. Raises `NtpError`, with what was expected and found, for anything else."""
    return core_of(read_weights(path, MADE_BY), path)


def core_of(weights: Weights, path: Path) -> Checkpoint:
    """Return the core of a file. Raises `NtpError` for the weights of anything else."""
    found = _described(weights, path)
    is_backed = _fewest_weights(found) <= sum(tensor.numel() for tensor in found.tensors.values())
    core = Core(found.config, found.memory) if is_backed else None  # no size is allocated on a file's word
    if core is None or shapes(core.state_dict()) != shapes(found.tensors):
        command = shortened(found.recipe.get("command", "ntp train"))
        raise NtpError(
            f"{path}: the weights do not fit the core that the checkpoint describes, which is of another "
            f"version perhaps; train anew: {command}"
        )
    core.load_state_dict(found.tensors)
    return Checkpoint(core.eval(), found.recipe)


def _fewest_weights(found: _File) -> int:
    """Return a lower bound, in which every size has its part, of the weights of the described core."""
    config, memory = found.config, found.memory
    layers = config.width * (config.rounds + config.kernel)
    heads = config.hops + memory.slots + memory.arity**2 + memory.value_arity * memory.choices
    embedded = len(memory.rows) * config.row_width + len(memory.types) * config.type_width
    return config.width * (layers + heads) + embedded


def save_training(trainer: Trainer, path: Path, data: Any = None) -> None:
    """Write the core, the optimiser's state, the iteration, and what it is trained on, to go on from."""
    tensors = {f"core.{name}": value for name, value in trainer.core.state_dict().items()}
    for number, state in trainer.optimiser.state_dict()["state"].items():
        tensors |= {f"optimiser.{number}.{name}": value for name, value in state.items()}
    facts = {"iteration": trainer.iteration, "training": asdict(trainer.config), "data": data}
    _write(tensors, trainer.core, facts, path)


def resume_training(trainer: Trainer, path: Path, data: Any = None) -> None:
    """Go on from a file. Raises `NtpError` for another training: another library, data or parameters."""
    found = _read(path)
    try:
        with decoding():
            progress = msgspec.convert(found.recipe, _Progress)
    except Unreadable as error:
        raise NtpError(f"{path}: is no unfinished training: {error}") from error
    wanted = json.loads(json.dumps([asdict(trainer.config), data]))
    if [progress.training, progress.data] != wanted or found.memory != trainer.core.memory:
        raise NtpError(f"{path}: was made with other settings; choose another --out or remove it")
    core = {n.removeprefix("core."): t for n, t in found.tensors.items() if n.startswith("core.")}
    state = _optimiser_state(trainer, found.tensors)
    if shapes(core) != shapes(trainer.core.state_dict()) or state is None:
        raise NtpError(f"{path}: is of another core; choose another --out or remove it")
    trainer.core.load_state_dict(core)
    groups = trainer.optimiser.state_dict()["param_groups"]
    trainer.optimiser.load_state_dict({"state": state, "param_groups": groups})
    trainer.iteration = progress.iteration


def _optimiser_state(trainer: Trainer, tensors: Mapping[str, Tensor]) -> dict[int, dict[str, Tensor]] | None:
    """Return the state of each parameter; None where they are of other parameters."""
    shapes = [parameter.shape for parameter in trainer.core.parameters()]
    state: dict[int, dict[str, Tensor]] = {}
    for name, tensor in tensors.items():
        if match := re.fullmatch(r"optimiser\.(\d{1,9})\.(\w+)", name):
            number = int(match[1])
            if number >= len(shapes) or tensor.shape not in (shapes[number], torch.Size(())):
                return None
            state.setdefault(number, {})[match[2]] = tensor
    return state if len({frozenset(each) for each in state.values()}) <= 1 else None


def strangers(memory: Memory, registry: Registry, program: str) -> list[str]:
    """Return what a core has not seen as it is declared now: programs and apis below a program, and types.

    Rows are matched by name and by the hash of the declaration: a new task needs no new checkpoint.
    """
    current = Memory.of(registry)
    known = {signature.name: signature for signature in memory.signatures()}
    callees = {row.signature.name: row.callees for row in current.rows}
    found, waiting = set(), [program]
    while waiting:
        name = waiting.pop()
        if name not in found:
            found.add(name)
            waiting += callees.get(name, ())
    changed = [s.name for s in current.signatures() if s.name in found and known.get(s.name) != s]
    return sorted(changed) + [name for name in current.types if name not in memory.types]


def check_fits(memory: Memory, registry: Registry, program: str, path: Path) -> None:
    """Raise `NtpError` where the core does not know all that a program may call."""
    unknown = strangers(memory, registry, program)
    if unknown:
        raise NtpError(
            f"{path}: is a checkpoint of library '{memory.library}' and has not seen "
            f"{', '.join(unknown)} as library '{registry.name}' declares them; record and train anew"
        )


def _write(tensors: Mapping[str, Tensor], core: Core, recipe: Mapping[str, Any], path: Path) -> None:
    header = {
        "format": FORMAT,
        "version": VERSION,
        "config": json.dumps(asdict(core.config)),
        "memory": json.dumps(asdict(core.memory)),
        "recipe": json.dumps(recipe, default=str),
    }
    write_weights(Weights(tensors, header), path)


def _read(path: Path) -> _File:
    return _described(read_weights(path, MADE_BY), path)


def _described(weights: Weights, path: Path) -> _File:
    """Return the contents of a file. Raises `NtpError` for the weights of anything else."""
    header = weights.header
    if weights.format != (FORMAT, VERSION):
        raise NtpError(f"{path}: expected a checkpoint of `ntp train`, found other safetensors")
    try:
        found = _File(
            weights.tensors,
            decode(header.get("config", ""), CoreConfig),
            decode(header.get("memory", ""), Memory),
            decode(header.get("recipe", ""), dict[str, Any]),
        )
    except Unreadable as error:
        raise NtpError(f"{path}: the checkpoint's description is damaged: {error}") from error
    return found
