"""`ntp check`: every mistake of a library, with its place."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from ntp_dsl.cli.report import print_diagnostics, print_lines, summary
from ntp_dsl.language.diagnostics.diagnostics import Diagnostic, Edit, NtpError
from ntp_dsl.language.diagnostics.rendering import shown_path
from ntp_dsl.language.loader import diagnose, find, read
from ntp_dsl.language.syntax.nodes import Span

if TYPE_CHECKING:
    from ntp_dsl.cli.apply_fixes import Texts

Sources = dict[Path | None, str]


class Format(StrEnum):
    TEXT = "text"
    JSON = "json"
    SARIF = "sarif"


def command(
    files: Annotated[list[Path], typer.Argument(metavar="FILE", help="Libraries or folders.")],
    static: Annotated[
        bool, typer.Option("--static", help="Only what the text alone can tell: nothing is simulated.")
    ] = False,
    execute: Annotated[
        bool, typer.Option("--execute", help="Import and run what the libraries leave to Python.")
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

    First by the text; where that is sound, by simulation in the kinematic world: apis that do not keep
    their word, goals that hold before anything is done or never, experts that go round in circles.
    Warnings and notes do not change the answer. Exit status: 0 sound, 1 there are errors, 2 there is no
    such file.

    Example: ntp check examples/block_stacking --static
    """
    if static and execute:
        raise NtpError("--static runs nothing and --execute runs all: choose one")
    if fix and diff:
        raise NtpError("--fix writes and --diff only shows: choose one")
    paths = [find(file) for file in files]
    if fix:
        from ntp_dsl.cli.apply_fixes import mend_files

        before = mend_files(lambda: _found(paths)[0], paths)
        _show_changes(before, {path: read(path) for path in before}, format)
    found, sources = _found(paths)
    if not static and not diff and not _has_errors(found):
        simulated, more = _simulated(paths, execute)
        found, sources = [*found, *simulated], {**sources, **more}
    if diff:
        from ntp_dsl.cli.apply_fixes import mended

        after = mended(found, paths)
        _show_changes({path: read(path) for path in after}, after, format)
    if format is Format.TEXT:
        _print_text(paths, found, sources)
    else:
        _print_document(found, format)
    return int(_has_errors(found))


def _has_errors(found: Sequence[Diagnostic]) -> bool:
    return any(each.severity == "error" for each in found)


def _simulated(paths: list[Path], execute: bool) -> tuple[list[Diagnostic], Sources]:
    """What the dynamic check finds, and the texts that it speaks of."""
    from ntp_dsl.cli.display import progress
    from ntp_dsl.dynamic.check import check_dynamically
    from ntp_dsl.language.loader import load
    from ntp_dsl.user_code.loading import with_python

    found: dict[Diagnostic, None] = {}
    with progress("simulating", None) as bar:
        for path in paths:
            registry = with_python(load(path)) if execute else load(path)
            told = lambda name, path=path: bar.describe(f"{shown_path(path)}: {name}")  # noqa: E731
            found |= dict.fromkeys(check_dynamically(registry, path, told=told))
    places = [note.span for each in found for note in each.notes] + [each.span for each in found]
    texts: Sources = {span.path: read(span.path) for span in places if span.path is not None}
    return list(found), texts


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
    from ntp_dsl.cli.apply_fixes import difference

    stream = sys.stdout if format is Format.TEXT else sys.stderr
    for path in before:
        print_lines(difference(path, before[path], after[path]), stream)


def _print_text(paths: list[Path], found: Sequence[Diagnostic], sources: Sources) -> None:
    print_diagnostics(found, sources)
    told = summary(found)
    if _has_errors(found):
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
        sound = not _has_errors(found)
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
