"""Which checkpoint a command runs: the one that is named, or the shipped one that fits."""

from __future__ import annotations

from pathlib import Path

from ntp_dsl.language.diagnostics.diagnostics import NtpError
from ntp_dsl.language.loader import load
from ntp_dsl.tasks.instances import find_task


def model_or_expert(library: Path, task: str, model: Path | None, expert: bool) -> Path | None:
    """The checkpoint to run, or None for the script. Raises `NtpError` where both are asked for."""
    if expert and model is not None:
        raise NtpError("--expert needs no --model: the script decides")
    return None if expert else model_for(library, task, model)


def model_for(library: Path, task: str, model: Path | None) -> Path:
    """Raises `NtpError` where nothing fits, with the lines that would make one."""
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
        f"to make one:\n"
        f"  ntp record {library} {task} -n 300 --out runs/data\n"
        f"  ntp train {library} --data runs/data --out runs/model"
    )
