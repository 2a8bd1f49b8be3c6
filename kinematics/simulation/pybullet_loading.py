"""PyBullet, imported without the build line that it prints."""

import contextlib
import ctypes
import importlib
import os
import sys
from collections.abc import Iterator
from typing import Any


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


def load() -> Any:
    """Return the module `pybullet`."""
    if "pybullet" in sys.modules:
        return sys.modules["pybullet"]
    with output_silenced():
        return importlib.import_module("pybullet")
