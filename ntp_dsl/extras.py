"""Which extra of the package installs which module, and what to say where one is missing."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager

from ntp_dsl.language.diagnostics.diagnostics import NtpError

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
    "daqp": "arm",
    "mujoco": "arm",
    "ompl": "arm",
    "pybullet": "arm",
    "pybullet_data": "arm",
    "rerun": "viz",
    "pandas": "notebook",
    "pink": "bench",
    "pybullet_planning": "bench",
}
PYBULLET = {"pybullet", "pybullet_data", "pybullet_planning"}
LAST_WITH_PYBULLET = (3, 11)


def missing(who: str, module: str | None, python: tuple[int, int], chosen: str = "") -> str | None:
    """Return the sentence for what lacks a module, or None where no extra installs it.

    Args:
        python: the version that it runs on.
        chosen: how another world is chosen.
    """
    top = (module or "").partition(".")[0]
    if top not in EXTRAS:
        return None
    if top in PYBULLET and python > LAST_WITH_PYBULLET:
        here, last = (".".join(map(str, version)) for version in (python, LAST_WITH_PYBULLET))
        return (
            f"{who} needs PyBullet, which has no wheels for Python {here}: use Python {last}; "
            f"the mujoco world and the kinematic one{chosen} work here"
        )
    return f'{who} needs {top}, which is not installed: pip install "ntp_dsl[{EXTRAS[top]}]"'


@contextmanager
def needing(who: str) -> Iterator[None]:
    """Raise `NtpError` with the sentence where a module of an extra is missing; also a decorator."""
    try:
        yield
    except ModuleNotFoundError as error:
        sentence = missing(who, error.name, sys.version_info[:2])
        if sentence is None:  # not for want of an extra
            raise
        raise NtpError(sentence) from error
