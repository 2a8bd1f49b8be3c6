"""File names, and writing files so that they appear under their names only when whole."""

from __future__ import annotations

import os
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path


@contextmanager
def written_whole(path: Path) -> Iterator[Path]:
    """Yield a path beside the final one, which replaces it on success and is removed on failure."""
    path.parent.mkdir(parents=True, exist_ok=True)
    partial = path.with_name(f".{path.name}.{os.getpid()}.partial")
    try:
        yield partial
        os.replace(partial, path)
    finally:
        partial.unlink(missing_ok=True)


def rewrite(path: Path, text: str) -> None:
    """Replace the text of a file, keeping links, permissions and line endings."""
    target = path.resolve()
    with written_whole(target) as partial:
        partial.write_bytes(text.encode())
        shutil.copymode(target, partial)


def episode_files(folder: Path, number: int) -> tuple[Path, Path]:
    """Return the paths of an episode's trace and of its demonstration."""
    stem = f"episode_{number:05d}"
    return folder / f"{stem}.trace.jsonl", folder / f"{stem}.demo.parquet"
