"""What reading a file must not do: run anything, or write, move or delete a file."""

from __future__ import annotations

import gc
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

FORBIDDEN = {
    "exec", "compile", "subprocess.Popen", "os.system", "os.exec", "os.posix_spawn", "os.fork", "os.remove",
    "os.rename", "os.rmdir", "os.mkdir", "os.truncate", "shutil.rmtree", "socket.connect",
}  # fmt: skip
WRITING = os.O_WRONLY | os.O_RDWR | os.O_CREAT | os.O_TRUNC

_is_watching = False
_found: list[str] = []


def _hook(event: str, arguments: tuple[Any, ...]) -> None:
    if not _is_watching:
        return
    if event in FORBIDDEN or event == "open" and isinstance(arguments[2], int) and arguments[2] & WRITING:
        _found.append(f"{event}{arguments}"[:200])


sys.addaudithook(_hook)


@contextmanager
def harmless() -> Iterator[None]:
    """Assert that nothing forbidden happens inside."""
    global _is_watching
    gc.disable()  # what other tests left to be cleaned up is not cleaned up inside
    _found.clear()
    _is_watching = True
    try:
        yield
    finally:
        _is_watching = False
        gc.enable()
    assert not _found, _found[:3]
