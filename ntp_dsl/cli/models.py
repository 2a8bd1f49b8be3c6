"""Which checkpoint a command runs: the one that is named, or the shipped one that fits."""

from __future__ import annotations

from pathlib import Path

from ntp_dsl.cli.display import messages
from ntp_dsl.core.checkpoint import check_fits, load_core
from ntp_dsl.language.diagnostics import NtpError
from ntp_dsl.language.loader import load
from ntp_dsl.resources import checkpoints_folder
from ntp_dsl.tasks import find_task


def model_for(library: Path, task: str, model: Path | None) -> Path:
    """Raises `NtpError` where nothing fits, with the lines that would make one."""
    registry = load(library)
    find_task(registry, task)
    path = model or checkpoints_folder() / f"{registry.name}.safetensors"
    if model is None and not path.exists():
        raise NtpError(
            f"no shipped checkpoint fits library '{registry.name}'; to make one:\n"
            f"  ntp record {library} {task} -n 300 --out runs/data\n"
            f"  ntp train {library} --data runs/data --out runs/model"
        )
    changed = check_fits(load_core(path).core.memory, registry, path)
    if changed:
        messages.print(f"{path.name}: has not seen, or not as they are now: {', '.join(changed)}")
    return path
