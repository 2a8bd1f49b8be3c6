"""Selection of the checkpoint that a command runs: the given one, or the core that ships."""

from __future__ import annotations

from pathlib import Path

from ntp_dsl.language.diagnostics.diagnostics import NtpError
from ntp_dsl.traces.decision import Dispatch


def model_or_expert(model: Path | None, expert: bool, dispatch: Dispatch | None = None) -> Path | None:
    """Return the checkpoint to run, None for the scripted expert. Raises `NtpError` where both are given."""
    if expert and model is not None:
        raise NtpError("--expert needs no --model: the scripted expert decides")
    if expert and dispatch is not None:
        raise NtpError("--expert needs no --dispatch: the scripted expert decides")
    return None if expert else model_or_shipped(model)


def model_or_shipped(model: Path | None) -> Path:
    """Return the checkpoint to run."""
    from ntp_dsl.core.one_core import shipped_core  # the expert needs no torch

    return model or shipped_core()
