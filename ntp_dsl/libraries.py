"""Libraries in Python: load one, check one, see who calls whom. The base installation has all of it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from ntp_dsl.graph import calls
from ntp_dsl.graph.picture import CallPicture
from ntp_dsl.language import loader
from ntp_dsl.language.checker import Report
from ntp_dsl.language.registry import Registry
from ntp_dsl.user_code.loading import with_functions, with_python


def load(path: Path | str) -> Registry:
    """Load a library, and its Python, from an `.ntp` file, a folder with one, or an example's name.

    Raises `SourceError`, which carries every diagnostic, where it is not sound.
    """
    return with_python(loader.load(path))


def load_text(
    text: str, functions: Sequence[Callable[..., Any]] = (), path: Path | str | None = None
) -> Registry:
    """Load a library from a string.

    Args:
        functions: what the library leaves to Python: functions marked with `@expert`, `@predicate`, `@skill`
            or `@sampler`.
        path: where the text belongs: diagnostics name it, and `use` looks beside it. It is not opened.

    Raises `SourceError`, which carries every diagnostic, where it is not sound, and `NtpError` for functions
    that the library does not ask for.
    """
    return with_functions(loader.load_text(text, path), functions)


def diagnose(path: Path | str) -> Report:
    """Check a library without its Python: an `.ntp` file, a folder with one, or an example's name."""
    return loader.diagnose(loader.find(path))


def call_graph(registry: Registry, program: str | None = None) -> CallPicture:
    """Return who calls whom in a library, as a picture.

    Args:
        program: shows this one and what it calls, and no other.
    """
    return CallPicture(calls.call_graph(registry, program))
