"""`ntp check`: every mistake of a library, with its place."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from enum import StrEnum
from pathlib import Path
from typing import Annotated, Any

import typer

from ntp_dsl.cli.mending import Texts, difference, mend_files, mended
from ntp_dsl.cli.report import print_diagnostics, print_lines, summary
from ntp_dsl.language.diagnostics import Diagnostic, Edit, NtpError
from ntp_dsl.language.loader import diagnose, find, read
from ntp_dsl.language.rendering import shown_path
from ntp_dsl.language.syntax import Span

Sources = dict[Path | None, str]


class Format(StrEnum):
    TEXT = "text"
    JSON = "json"
    SARIF = "sarif"


def command(
    files: Annotated[list[Path], typer.Argument(metavar="FILE", help="Libraries or folders.")],
    static: Annotated[
        bool, typer.Option("--static", help="Only what the text alone can tell: no world is asked.")
    ] = False,
    format: Annotated[
        Format, typer.Option(help="For people, for programs, or for tools that read SARIF 2.1.0.")
    ] = Format.TEXT,
    fix: Annotated[
        bool, typer.Option("--fix", help="Apply every fix that is certain, and check again.")
    ] = False,
    diff: Annotated[
        bool, typer.Option("--diff", help="Show what --fix would first change; write nothing.")
    ] = False,
) -> int:
    """Say whether libraries are sound, and every mistake that is in them.

    Warnings and notes do not change the answer. Exit status: 0 sound, 1 there are errors, 2 there is no
    such file.

    Example: ntp check examples/block_stacking --static
    """
    if fix and diff:
        raise NtpError("--fix writes and --diff only shows: choose one")
    paths = [find(file) for file in files]
    if fix:
        before = mend_files(lambda: _found(paths)[0], paths)
        _show_changes(before, {path: read(path) for path in before}, format)
    found, sources = _found(paths)
    if diff:
        after = mended(found, paths)
        _show_changes({path: read(path) for path in after}, after, format)
    if format is Format.TEXT:
        _print_text(paths, found, sources)
    else:
        _print_document(found, format)
    return int(any(each.severity == "error" for each in found))


def _found(paths: list[Path]) -> tuple[list[Diagnostic], Sources]:
    """What is found in all libraries; in those that several use, once."""
    found: dict[Diagnostic, None] = {}
    sources: Sources = {}
    for path in paths:
        report = diagnose(path)
        found |= dict.fromkeys(report.diagnostics)
        sources |= report.sources
    return list(found), sources


def _show_changes(before: Texts, after: Texts, format: Format) -> None:
    stream = sys.stdout if format is Format.TEXT else sys.stderr
    for path in before:
        print_lines(difference(path, before[path], after[path]), stream)


def _print_text(paths: list[Path], found: Sequence[Diagnostic], sources: Sources) -> None:
    print_diagnostics(found, sources)
    told = summary(found)
    if any(each.severity == "error" for each in found):
        fixable = sum(each.fix is not None for each in found)
        print(told + (f" ({fixable} can be mended by --fix)" if fixable else ""))
    else:
        libraries = ", ".join(shown_path(path) for path in paths)
        print(f"sound: {libraries}" + (f" ({told})" if told else ""))


def _print_document(found: Sequence[Diagnostic], format: Format) -> None:
    from ntp_dsl.cli import sarif
    from ntp_dsl.cli.display import print_json

    if format is Format.SARIF:
        print_json(sarif.document(found))
    else:
        sound = not any(each.severity == "error" for each in found)
        print_json({"sound": sound, "diagnostics": [_row(each) for each in found]})


def _row(diagnostic: Diagnostic) -> dict[str, Any]:
    fix = diagnostic.fix
    return {
        "code": diagnostic.code,
        "severity": diagnostic.severity,
        "message": diagnostic.message,
        "help": diagnostic.help,
        **_place(diagnostic.span),
        "notes": [{"message": note.message, **_place(note.span)} for note in diagnostic.notes],
        "fix": fix and {**_edit(fix), "also": [_edit(each) for each in fix.also]},
    }


def _edit(edit: Edit) -> dict[str, Any]:
    return {"replacement": edit.replacement, **_place(edit.span)}


def _place(span: Span) -> dict[str, Any]:
    return {
        "path": str(span.path) if span.path else None,
        "line": span.line,
        "column": span.column,
        "end_line": span.end_line,
        "end_column": span.end_column,
    }
