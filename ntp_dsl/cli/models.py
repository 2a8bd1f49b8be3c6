"""Selection of the checkpoint that a command runs: the given one, or a shipped one that fits."""

from __future__ import annotations

from pathlib import Path

from ntp_dsl.language.diagnostics.diagnostics import NtpError
from ntp_dsl.language.loader import load
from ntp_dsl.tasks.instances import find_task


def model_or_expert(library: Path, task: str, model: Path | None, expert: bool) -> Path | None:
    """Return the checkpoint to run, None for the scripted expert. Raises `NtpError` where both are given."""
    if expert and model is not None:
        raise NtpError("--expert needs no --model: the scripted expert decides")
    return None if expert else model_for(library, task, model)


def model_for(library: Path, task: str, model: Path | None) -> Path:
    """Return the checkpoint to run. Raises `NtpError` where none fits, with the commands that make one."""
    from ntp_dsl.core.checkpoint import check_fits, load_core  # the expert needs no torch
    from ntp_dsl.core.shipped import shipped_checkpoint

    registry = load(library)
    declared = find_task(registry, task).run
    assert declared is not None
    if model is not None:
        check_fits(load_core(model).core.memory, registry, declared.callee, model)
        return model
    if path := shipped_checkpoint(registry, declared.callee):
        return path
    raise NtpError(
        f"no shipped checkpoint knows '{declared.callee}' as library '{registry.name}' declares it; "
        f"to train one (-n 50 is quick, and less reliable):\n"
        f"  ntp record {library} {task} -n 300 --out runs/data\n"
        f"  ntp train {library} --data runs/data --out runs/model"
    )
