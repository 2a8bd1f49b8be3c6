"""File names, and writing files so that they appear under their names only when whole."""

from __future__ import annotations

import fcntl
import os
import re
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from errno import EISDIR
from pathlib import Path

LOCK = ".ntp.lock"


@contextmanager
def written_whole(path: Path) -> Iterator[Path]:
    """Yield a path beside the final one, which replaces it on success and is removed on failure.

    A link is followed, and a device or pipe is written to: neither is replaced. Raises `OSError`, which
    names the file.
    """
    try:
        with _written_whole(path) as whole:
            yield whole
    except OSError as error:
        if error.filename is None and error.errno is not None:  # so raised by writes and `close`
            raise OSError(error.errno, error.strerror, str(path)) from error
        raise


@contextmanager
def _written_whole(path: Path) -> Iterator[Path]:
    target = path.resolve()
    if target.is_dir():
        raise IsADirectoryError(EISDIR, "is a folder, not a file", str(path))
    if target.exists() and not target.is_file():
        with tempfile.TemporaryDirectory() as folder:
            yield (whole := Path(folder) / "whole")
            with target.open("wb") as stream:
                stream.write(whole.read_bytes())
        return
    target.parent.mkdir(parents=True, exist_ok=True)
    partial = target.with_name(f".{target.name}.{os.getpid()}.partial")
    try:
        yield partial
        os.replace(partial, target)
    finally:
        partial.unlink(missing_ok=True)


@contextmanager
def locked(folder: Path) -> Iterator[None]:
    """Hold a folder for this process alone. Raises `BlockingIOError` where another holds it."""
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / LOCK
    with path.open("w") as stream:
        fcntl.flock(stream, fcntl.LOCK_EX | fcntl.LOCK_NB)
        try:
            yield
        finally:
            path.unlink(missing_ok=True)


def rewrite(path: Path, text: str) -> None:
    """Replace the text of a file, keeping links, permissions and line endings."""
    target = path.resolve()
    with written_whole(target) as partial:
        partial.write_bytes(text.encode())
        shutil.copymode(target, partial)


EPISODE_FILE = re.compile(r"episode_\d{5,}\.(trace\.jsonl|demo\.parquet|say\.txt)")


def episode_files(folder: Path, number: int) -> tuple[Path, Path]:
    """Return the paths of an episode's trace and of its demonstration."""
    stem = f"episode_{number:05d}"
    return folder / f"{stem}.trace.jsonl", folder / f"{stem}.demo.parquet"


def sentences_file(folder: Path, number: int) -> Path:
    """Return the path of the sentences that say what an episode's demonstration shows."""
    return folder / f"episode_{number:05d}.say.txt"
