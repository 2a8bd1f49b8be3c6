"""PyBullet, imported without the build line that it prints."""

import contextlib
import ctypes
import importlib
import os
import sys
from collections.abc import Iterator
from importlib.machinery import PathFinder
from pathlib import Path
from typing import Any

from kinematics.errors import UnusableRobot


@contextlib.contextmanager
def output_silenced() -> Iterator[None]:
    """Keep what compiled code prints from standard output and standard error."""
    sys.stdout.flush()
    sys.stderr.flush()
    flush_c = ctypes.CDLL(None).fflush
    flush_c(None)
    kept = [os.dup(descriptor) for descriptor in (1, 2)]
    devnull = os.open(os.devnull, os.O_WRONLY)
    try:
        for descriptor in (1, 2):
            os.dup2(devnull, descriptor)
        yield
    finally:
        sys.stdout.flush()
        sys.stderr.flush()
        flush_c(None)  # output of C is still in its own buffer
        for descriptor, original in zip((1, 2), kept, strict=True):
            os.dup2(original, descriptor)
            os.close(original)
        os.close(devnull)


def load_arm(bullet: Any, client: int, path: Path, source: Path) -> int:
    """Load an arm's URDF, and return its identity; raise `UnusableRobot`, which names the source."""
    try:
        with output_silenced():
            identity: int = bullet.loadURDF(str(path), useFixedBase=True, physicsClientId=client)
    except bullet.error as unexpected:
        raise UnusableRobot(f"{source}: PyBullet cannot read it: {unexpected}") from unexpected
    return identity


def is_installed() -> bool:
    """Return whether there is a PyBullet; it is not imported."""
    return "pybullet" in sys.modules or PathFinder.find_spec("pybullet") is not None


def load() -> Any:
    """Return the module `pybullet`."""
    if "pybullet" in sys.modules:
        return sys.modules["pybullet"]
    with output_silenced():
        return importlib.import_module("pybullet")
