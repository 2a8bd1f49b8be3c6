"""Which extra of the package installs which module, and what to say where a command lacks one."""

from __future__ import annotations

import sys

# Module -> the extra of `pyproject.toml` that installs it; the base installation lacks them all.
EXTRAS = {
    "numpy": "sim",
    "scipy": "sim",
    "pyarrow": "sim",
    "PIL": "sim",
    "torch": "learn",
    "safetensors": "learn",
    "pinocchio": "arm",
    "coal": "arm",
    "mink": "arm",
    "mujoco": "arm",
    "ompl": "arm",
    "pybullet": "arm",
    "pybullet_data": "arm",
    "rerun": "viz",
    "pink": "bench",
    "pybullet_planning": "bench",
}
PYBULLET = {"pybullet", "pybullet_data", "pybullet_planning"}
LAST_WITH_PYBULLET = (3, 11)

# What a command can do without the missing module.
INSTEAD = {"ntp check": "; --static needs nothing more"}


def missing(command: str, module: str | None) -> str | None:
    """Return the sentence for a command that lacks a module, or None where no extra installs it."""
    top = (module or "").partition(".")[0]
    if top not in EXTRAS:
        return None
    if top in PYBULLET and sys.version_info[:2] > LAST_WITH_PYBULLET:
        here, last = (".".join(map(str, version)) for version in (sys.version_info[:2], LAST_WITH_PYBULLET))
        return (
            f"{command} needs PyBullet, which has no wheels for Python {here}: use Python {last}; "
            f"the kinematic world (--world kinematic) works here"
        )
    install = f'pip install "ntp_dsl[{EXTRAS[top]}]"'
    return f"{command} needs {top}, which is not installed: {install}{INSTEAD.get(command, '')}"
