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
from safetensors import SafetensorError, safe_open
from safetensors.torch import save
from torch import Tensor

from ntp_dsl.common.decoding import Count, Unreadable, decode, decoding
from ntp_dsl.common.files import written_whole
from ntp_dsl.common.text import shortened
from ntp_dsl.core.config import CoreConfig
from ntp_dsl.core.memory import Memory
from ntp_dsl.core.model import Core
from ntp_dsl.core.training import Trainer
from ntp_dsl.language.diagnostics.diagnostics import NtpError
from ntp_dsl.language.registry import Registry

FORMAT = "ntp-checkpoint"
VERSION = "1"


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
    found = _read(path)
    is_backed = _fewest_weights(found) <= sum(tensor.numel() for tensor in found.tensors.values())
    core = Core(found.config, found.memory) if is_backed else None  # no size is allocated on a file's word
    if core is None or _shapes(core.state_dict()) != _shapes(found.tensors):
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
    if _shapes(core) != _shapes(trainer.core.state_dict()) or state is None:
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


def _shapes(tensors: Mapping[str, Tensor]) -> dict[str, tuple[torch.Size, torch.dtype]]:
    return {name: (tensor.shape, tensor.dtype) for name, tensor in tensors.items()}


def _write(tensors: Mapping[str, Tensor], core: Core, recipe: Mapping[str, Any], path: Path) -> None:
    header = {
        "format": FORMAT,
        "version": VERSION,
        "config": json.dumps(asdict(core.config)),
        "memory": json.dumps(asdict(core.memory)),
        "recipe": json.dumps(recipe, default=str),
    }
    with written_whole(path) as partial:
        partial.write_bytes(save(dict(tensors), header))


def _read(path: Path) -> _File:
    if not path.is_file():
        raise NtpError(f"{path}: no such checkpoint; `ntp train` makes them")
    try:
        with safe_open(path, framework="pt") as file:
            header = file.metadata() or {}
            tensors = {name: file.get_tensor(name) for name in file.keys()}  # noqa: SIM118
    except (SafetensorError, OSError, ValueError) as error:
        raise NtpError(
            f"{path}: expected a checkpoint (safetensors), found something else or a truncated file"
        ) from error
    if header.get("format") != FORMAT or header.get("version") != VERSION:
        raise NtpError(f"{path}: expected a checkpoint of `ntp train`, found other safetensors")
    try:
        found = _File(
            tensors,
            decode(header.get("config", ""), CoreConfig),
            decode(header.get("memory", ""), Memory),
            decode(header.get("recipe", ""), dict[str, Any]),
        )
    except Unreadable as error:
        raise NtpError(f"{path}: the checkpoint's description is damaged: {error}") from error
    if not all(torch.isfinite(tensor).all() for tensor in tensors.values()):
        raise NtpError(f"{path}: expected finite weights, found NaN or infinity; train anew")
    return found
