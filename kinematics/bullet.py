"""PyBullet, imported without the build line that it prints on standard output."""

import contextlib
import ctypes
import importlib
import os
import sys
from collections.abc import Iterator
from typing import Any


@contextlib.contextmanager
def standard_output_silenced() -> Iterator[None]:
    """Nothing that compiled code prints reaches file descriptor 1 meanwhile."""
    sys.stdout.flush()
    ctypes.CDLL(None).fflush(None)
    kept = os.dup(1)
    nowhere = os.open(os.devnull, os.O_WRONLY)
    try:
        os.dup2(nowhere, 1)
        yield
    finally:
        ctypes.CDLL(None).fflush(None)  # what C has printed is still in its own buffer
        os.dup2(kept, 1)
        os.close(kept)
        os.close(nowhere)


def load() -> Any:
    """The module `pybullet`."""
    if "pybullet" in sys.modules:
        return sys.modules["pybullet"]
    with standard_output_silenced():
        return importlib.import_module("pybullet")
