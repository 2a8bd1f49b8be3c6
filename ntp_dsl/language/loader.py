"""From a file, a folder or a text to a registry, or to all that is wrong with it."""

from __future__ import annotations

import gc
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from functools import partial
from pathlib import Path

from ntp_dsl.common.resources import examples_folder, library_folder
from ntp_dsl.language.checker import Report, check_units
from ntp_dsl.language.diagnostics.diagnostics import NtpError
from ntp_dsl.language.names.incremental_cache import IncrementalCache
from ntp_dsl.language.names.used_libraries import SUFFIX, Reading, ReadLibrary, available_names, read
from ntp_dsl.language.parsing import parser
from ntp_dsl.language.registry import Registry

__all__ = [
    "SUFFIX", "Report", "check_files", "diagnose", "diagnose_text", "find", "load", "load_text", "read",
]  # fmt: skip


def load(path_or_folder: Path | str) -> Registry:
    """Parse and check a library and all that it uses; `SourceError` carries every diagnostic.

    Args:
        path_or_folder: an `.ntp` file, a folder that holds one, or the name of an example or of a
            standard library.
    """
    return diagnose(find(path_or_folder)).checked()


def load_text(text: str, path: Path | str | None = None) -> Registry:
    """Parse and check a library that is given as text, and all that it uses, as `load` does.

    Args:
        path: where the text belongs: messages name it, and `use` looks beside it. The file is not opened.
            Without a path, `use` finds the standard libraries alone.
    """
    return diagnose_text(text, path).checked()


def diagnose(path: Path) -> Report:
    """Check the form and meaning of a file and of all that it uses."""
    return check_files(path)


def diagnose_text(text: str, path: Path | str | None = None) -> Report:
    """Check a text as `load_text` does."""
    where = None if path is None else Path(path)
    return check_files(where, {where: text})


def check_files(
    path: Path | None,
    texts: Mapping[Path | None, str] | None = None,
    read_library: ReadLibrary = parser.read,
    cache: IncrementalCache | None = None,
) -> Report:
    """Read a library and all that it uses, and check them: what all ways of loading have in common.

    Args:
        texts: in place of what is on the disk.
        read_library: what to call in place of the parser, such as a function with a cache.
        cache: of earlier checks.
    """
    with _uncollected():
        reading = Reading(path, texts or {}, read_library)
        units = reading.units()
        return check_units(units, reading.diagnostics, reading.sources, partial(available_names, path), cache)


@contextmanager
def _uncollected() -> Iterator[None]:
    """Pause garbage collection, which takes a third of the time: a check makes many objects and drops few."""
    was_enabled = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if was_enabled:
            gc.enable()


def find(path_or_folder: Path | str) -> Path:
    """Return the file that is meant; `NtpError` says what was looked for where there is none."""
    given = Path(path_or_folder)
    is_bare = len(given.parts) == 1 and not given.suffix
    if is_bare and not given.exists():
        named = [examples_folder() / given, library_folder() / f"{given}{SUFFIX}"]
        given = next((path for path in named if path.exists()), given)
    if given.is_dir():
        return _only_library(given)
    if not given.exists():
        known = ", ".join(sorted(path.parent.name for path in examples_folder().glob(f"*/*{SUFFIX}")))
        hint = f"; the examples are: {known}" if is_bare and known else ""
        if (file := Path(f"{path_or_folder}{SUFFIX}")).is_file():
            hint = f"; did you mean {file}?"
        raise NtpError(f"there is no library at '{path_or_folder}'{hint}")
    return given


def _only_library(folder: Path) -> Path:
    found = sorted(folder.glob(f"*{SUFFIX}"))
    if len(found) == 1:
        return found[0]
    if not found:
        raise NtpError(f"the folder '{folder}' holds no {SUFFIX} file")
    # A folder that carries its own helper libraries still has one that is named after it.
    eponymous = folder / f"{folder.resolve().name}{SUFFIX}"
    if eponymous in found:
        return eponymous
    listing = ", ".join(path.name for path in found)
    raise NtpError(f"the folder '{folder}' holds several libraries ({listing}); name one of them")
