"""Output of the commands: answers on standard output, everything else on standard error."""

from __future__ import annotations

import json
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any, Protocol

import msgspec
from rich.console import Console

if TYPE_CHECKING:
    from rich.progress import TaskID

FILE_WIDTH = 200  # [characters] of piped or redirected lines; a terminal knows its own width


class _Console(Console):
    def on_broken_pipe(self) -> None:
        raise  # the error that is being handled; rich would exit with status 1


answers = _Console(markup=False, highlight=False, width=None if sys.stdout.isatty() else FILE_WIDTH)
messages = _Console(
    stderr=True, markup=False, highlight=False, width=None if sys.stderr.isatty() else FILE_WIDTH
)


def print_json(document: Any) -> None:
    """Print a command's answer to `--json`: structs, dataclasses and built-in types, as one document."""
    print(json.dumps(msgspec.to_builtins(document), indent=2))


class Progress(Protocol):
    """The progress of a long computation."""

    def advance(self, steps: int = 1) -> None: ...

    def describe(self, description: str) -> None: ...


@contextmanager
def progress(description: str, total: int | None) -> Iterator[Progress]:
    """Show a bar on standard error that counts to `total`, where that is a terminal."""
    from rich.progress import BarColumn, MofNCompleteColumn, TextColumn, TimeRemainingColumn
    from rich.progress import Progress as RichProgress

    columns = (
        TextColumn("{task.description}"),
        BarColumn(),
        MofNCompleteColumn(),
        TimeRemainingColumn(),
    )
    bars = RichProgress(*columns, console=messages, disable=not messages.is_terminal)
    with bars:
        yield _Bar(bars, bars.add_task(description, total=total))


class _Bar:
    def __init__(self, bars: Any, task: TaskID) -> None:
        self._bars, self._task = bars, task

    def advance(self, steps: int = 1) -> None:
        self._bars.advance(self._task, steps)

    def describe(self, description: str) -> None:
        self._bars.update(self._task, description=description)
