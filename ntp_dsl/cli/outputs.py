"""Files that commands write: never over what they read, and never under another format's name."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from ntp_dsl.language.diagnostics.diagnostics import NtpError


def check_no_input(out: Path | None, inputs: Iterable[Path | None]) -> None:
    """Raise `NtpError` where a command would overwrite one of the files that it reads."""
    if out is not None and out.resolve() in {each.resolve() for each in inputs if each is not None}:
        raise NtpError(f"--out: {out} is read by this command and would be overwritten; give another file")


def check_ending(out: Path, ending: str) -> None:
    """Raise `NtpError` where a file's ending promises another format than the one that is written."""
    if out.suffix and out.suffix.lower() != ending:
        raise NtpError(f"--out: expected a file that ends in {ending}, the format written, found {out}")
