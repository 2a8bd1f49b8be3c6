"""What a user types, for tests that go through the command line."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path


def ntp(line: str, folder: Path) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "ntp_dsl", *line.split()]
    return subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)


def learnt(domain: Path, folder: Path) -> Path:
    """Return the checkpoint of a domain by `ntp record` and `ntp train` with their defaults."""
    name = domain.name
    for line in (f"record {domain} {name} -n 50 --out data", f"train {domain} --data data --out model"):
        done = ntp(line, folder)
        assert done.returncode == 0, done.stderr
    return folder / "model" / f"{name}.safetensors"
