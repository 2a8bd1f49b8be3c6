"""Checkpoints: safetensors, with the memory, the sizes and the exact recipe in the file's own header."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import torch
from safetensors import SafetensorError, safe_open
from safetensors.torch import save_file

from ntp_dsl.common.files import written_whole
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


def save_core(core: Core, recipe: Mapping[str, Any], path: Path) -> None:
    with written_whole(path) as partial:
        save_file(dict(core.state_dict()), partial, _header(core, recipe))


def load_core(path: Path) -> Checkpoint:
    """Raises `NtpError`, with what was expected and found, for anything but a whole checkpoint."""
    tensors, header = _read(path)
    try:
        core = Core(CoreConfig(**header["config"]), Memory.from_json(header["memory"]))
        recipe = header["recipe"]
    except (KeyError, TypeError, ValueError, RuntimeError) as error:
        raise NtpError(f"{path}: the checkpoint does not fit its own description: {error}") from error
    try:
        core.load_state_dict(tensors)
    except RuntimeError as error:
        command = recipe.get("command", "ntp train")
        raise NtpError(
            f"{path}: the weights do not fit the core that the checkpoint describes, which is of another "
            f"version perhaps; train anew: {command}"
        ) from error
    return Checkpoint(core.eval(), recipe)


def save_training(trainer: Trainer, path: Path, data: Any = None) -> None:
    """The core, the optimiser's state, the iteration, and what it is trained on, to go on from."""
    tensors = {f"core.{name}": value for name, value in trainer.core.state_dict().items()}
    for number, state in trainer.optimiser.state_dict()["state"].items():
        tensors |= {f"optimiser.{number}.{name}": value for name, value in state.items()}
    facts = {
        "iteration": trainer.iteration,
        "training": asdict(trainer.config),
        "data": data,
        "memory": trainer.core.memory.to_json(),
    }
    with written_whole(path) as partial:
        save_file(tensors, partial, _header(trainer.core, facts))


def resume_training(trainer: Trainer, path: Path, data: Any = None) -> None:
    """Raises `NtpError` where the file is of another training: another library, other data or knobs."""
    tensors, header = _read(path)
    wanted = {
        "training": asdict(trainer.config),
        "data": data,
        "memory": trainer.core.memory.to_json(),
    }
    if any(header["recipe"].get(key) != json.loads(json.dumps(wanted[key])) for key in wanted):
        raise NtpError(f"{path}: was made with other settings; choose another --out or remove it")
    core = {n.removeprefix("core."): t for n, t in tensors.items() if n.startswith("core.")}
    try:
        trainer.core.load_state_dict(core)
    except RuntimeError as error:
        raise NtpError(f"{path}: is of another core; choose another --out or remove it") from error
    state: dict[int, dict[str, torch.Tensor]] = {}
    for name, tensor in tensors.items():
        if name.startswith("optimiser."):
            _, number, key = name.split(".")
            state.setdefault(int(number), {})[key] = tensor
    whole = trainer.optimiser.state_dict()
    trainer.optimiser.load_state_dict({"state": state, "param_groups": whole["param_groups"]})
    trainer.iteration = int(header["recipe"]["iteration"])


def strangers(memory: Memory, registry: Registry, program: str) -> list[str]:
    """What a core has never seen as it is declared now: programs and apis below a program, and types.

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
    """Raises `NtpError` where the core does not know all that a program may call."""
    unknown = strangers(memory, registry, program)
    if unknown:
        raise NtpError(
            f"{path}: is a checkpoint of library '{memory.library}' and has not seen "
            f"{', '.join(unknown)} as library '{registry.name}' declares them; record and train anew"
        )


def _header(core: Core, recipe: Mapping[str, Any]) -> dict[str, str]:
    return {
        "format": FORMAT,
        "version": VERSION,
        "config": json.dumps(asdict(core.config)),
        "memory": json.dumps(core.memory.to_json()),
        "recipe": json.dumps(recipe, default=str),
    }


def _read(path: Path) -> tuple[dict[str, torch.Tensor], dict[str, Any]]:
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
        parsed = {name: json.loads(header[name]) for name in ("config", "memory", "recipe")}
    except (KeyError, ValueError) as error:
        raise NtpError(f"{path}: the checkpoint's description is damaged: {error}") from error
    return tensors, parsed
