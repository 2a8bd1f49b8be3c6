"""`ntp check`: all diagnostics of a library."""

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
    static: Annotated[bool, typer.Option("--static", help="Check the text only; simulate nothing.")] = False,
    execute: Annotated[
        bool, typer.Option("--execute", help="Import and run the libraries' own Python functions.")
    ] = False,
    format: Annotated[Format, typer.Option(help="Output as text, JSON, or SARIF 2.1.0.")] = Format.TEXT,
    fix: Annotated[bool, typer.Option("--fix", help="Apply all safe fixes, and check again.")] = False,
    diff: Annotated[
        bool, typer.Option("--diff", help="Show what --fix would change first; write nothing.")
    ] = False,
) -> int:
    """Check libraries, and report every error with its location.

    The text is checked first. If it has no errors, the library is simulated in the kinematic world, to
    find apis that violate their contract, goals that hold from the start or are never reached, and
    experts that never end. Exit status: 0 no errors (warnings and notes do not count), 1 errors, 2 there
    is no such file.

    Example: ntp check examples/block_stacking --static
    """
    if static and execute:
        raise NtpError("--static simulates nothing and --execute everything: choose one")
    if fix and diff:
        raise NtpError("--fix writes files and --diff only shows changes: choose one")
    paths = [find(file) for file in files]
    if fix:
        from ntp_dsl.cli.apply_fixes import fix_files

        before = fix_files(lambda: _diagnose(paths)[0], paths)
        _show_changes(before, {path: read(path) for path in before}, format)
    diagnostics, sources = _diagnose(paths)
    if not static and not diff and not _has_errors(diagnostics):
        simulated, more = _simulate(paths, execute)
        diagnostics, sources = [*diagnostics, *simulated], {**sources, **more}
    if diff:
        from ntp_dsl.cli.apply_fixes import fixed_texts

        after = fixed_texts(diagnostics, paths)
        _show_changes({path: read(path) for path in after}, after, format)
    if format is Format.TEXT:
        _print_text(paths, diagnostics, sources)
    else:
        _print_document(diagnostics, format)
    return int(_has_errors(diagnostics))


def _has_errors(diagnostics: Sequence[Diagnostic]) -> bool:
    return any(each.severity == "error" for each in diagnostics)


def _simulate(paths: list[Path], execute: bool) -> tuple[list[Diagnostic], Sources]:
    """Return the diagnostics of the dynamic check, and the texts that they refer to."""
    from ntp_dsl.cli.display import progress
    from ntp_dsl.dynamic.check import check_dynamically
    from ntp_dsl.language.loader import load
    from ntp_dsl.user_code.loading import with_python

    diagnostics: dict[Diagnostic, None] = {}
    with progress("simulating", None) as bar:
        for path in paths:
            registry = with_python(load(path)) if execute else load(path)
            report = lambda name, path=path: bar.describe(f"{shown_path(path)}: {name}")  # noqa: E731
            diagnostics |= dict.fromkeys(check_dynamically(registry, path, on_step=report))
    places = [note.span for each in diagnostics for note in each.notes] + [each.span for each in diagnostics]
    texts: Sources = {span.path: read(span.path) for span in places if span.path is not None}
    return list(diagnostics), texts


def _diagnose(paths: list[Path]) -> tuple[list[Diagnostic], Sources]:
    """Return the diagnostics of all libraries; those of shared libraries occur once."""
    diagnostics: dict[Diagnostic, None] = {}
    sources: Sources = {}
    for path in paths:
        report = diagnose(path)
        diagnostics |= dict.fromkeys(report.diagnostics)
        sources |= report.sources
    return list(diagnostics), sources


def _show_changes(before: Texts, after: Texts, format: Format) -> None:
    from ntp_dsl.cli.apply_fixes import difference

    stream = sys.stdout if format is Format.TEXT else sys.stderr
    for path in before:
        print_lines(difference(path, before[path], after[path]), stream)


def _print_text(paths: list[Path], diagnostics: Sequence[Diagnostic], sources: Sources) -> None:
    print_diagnostics(diagnostics, sources)
    counts = summary(diagnostics)
    if _has_errors(diagnostics):
        fixable = sum(each.fix is not None for each in diagnostics)
        print(counts + (f" ({fixable} fixable with --fix)" if fixable else ""))
    else:
        libraries = ", ".join(shown_path(path) for path in paths)
        print(f"sound: {libraries}" + (f" ({counts})" if counts else ""))


def _print_document(diagnostics: Sequence[Diagnostic], format: Format) -> None:
    from ntp_dsl.cli import sarif
    from ntp_dsl.cli.display import print_json

    if format is Format.SARIF:
        print_json(sarif.document(diagnostics))
    else:
        sound = not _has_errors(diagnostics)
        print_json({"sound": sound, "diagnostics": [_row(each) for each in diagnostics]})


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
