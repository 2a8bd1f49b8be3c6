"""Which of the checkpoints that ship with the package knows a program."""

from __future__ import annotations

from pathlib import Path

from ntp_dsl.common.resources import checkpoints_folder
from ntp_dsl.core.checkpoint import load_core, strangers
from ntp_dsl.language.registry import Registry


def shipped_checkpoint(registry: Registry, program: str) -> Path | None:
    """Return the first that has learnt a program, and all that it calls, as the library declares it."""
    for path in sorted(checkpoints_folder().glob("*.safetensors")):
        if not strangers(load_core(path).core.memory, registry, program):
            return path
    return None
