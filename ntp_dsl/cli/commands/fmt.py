"""`ntp fmt`: libraries in canonical layout."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated

import typer

from ntp_dsl.cli.report import difference, print_diagnostics, print_lines, summary
from ntp_dsl.common.files import rewrite
from ntp_dsl.language.diagnostics.diagnostics import NtpError, SourceError
from ntp_dsl.language.diagnostics.rendering import shown_path
from ntp_dsl.language.formatting.canonical import format_text
from ntp_dsl.language.loader import SUFFIX, find, read

STDIN = Path("-")


def command(
    files: Annotated[
        list[Path], typer.Argument(metavar="FILE", help="Libraries or folders; - is standard input.")
    ],
    check: Annotated[bool, typer.Option("--check", help="Only report files that are not formatted.")] = False,
    diff: Annotated[bool, typer.Option("--diff", help="Only show the changes.")] = False,
) -> int:
    """Format libraries; their meaning and comments are kept.

    A file that does not parse is not changed. Exit status: 0 done, 1 a file does not parse or, with
    --check or --diff, is not formatted, 2 there is no such file.

    Example: ntp fmt examples/block_stacking --check
    """
    if files == [STDIN] and not (check or diff):
        return _filter()
    if STDIN in files:
        raise NtpError("standard input cannot be combined with files or options: ntp fmt -")
    statuses = [_format(path, check or diff, diff) for file in files for path in _libraries(file)]
    return max(statuses, default=0)


def _libraries(given: Path) -> list[Path]:
    """Return the library of a path, or all libraries of a folder."""
    return sorted(given.glob(f"*{SUFFIX}")) or [find(given)] if given.is_dir() else [find(given)]


def _filter() -> int:
    text = sys.stdin.buffer.read().decode("utf-8-sig", errors="replace")
    try:
        formatted = format_text(text)
    except SourceError as error:
        return _report(error)
    sys.stdout.write(formatted)
    return 0


def _format(path: Path, check_only: bool, show: bool) -> int:
    before = read(path)
    try:
        after = format_text(before, path)
    except SourceError as error:
        return _report(error)
    if after == before:
        return 0
    if show:
        print_lines(difference(path, before, after))
    if check_only:
        print(f"{shown_path(path)}: not in canonical layout; run `ntp fmt {shown_path(path)}`")
        return 1
    rewrite(path, after)
    print(f"formatted {shown_path(path)}")
    return 0


def _report(error: SourceError) -> int:
    print_diagnostics(error.diagnostics, error.sources, sys.stderr)
    print(f"{summary(error.diagnostics)}: not formatted", file=sys.stderr)
    return 1
