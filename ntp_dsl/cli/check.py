"""`ntp check`: every mistake of a library, with its place."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import Annotated, Any

import typer

from ntp_dsl.language.diagnostics import Diagnostic, Edit, render
from ntp_dsl.language.loader import diagnose, find
from ntp_dsl.language.syntax import Span


class Format(StrEnum):
    TEXT = "text"
    JSON = "json"


def command(
    files: Annotated[list[Path], typer.Argument(metavar="FILE", help="Libraries or folders.")],
    static: Annotated[
        bool, typer.Option("--static", help="Only what the text alone can tell: no world is asked.")
    ] = False,
    format: Annotated[Format, typer.Option(help="For people, or for machines.")] = Format.TEXT,
) -> int:
    """Say whether libraries are sound, and every mistake that is in them.

    Exit status: 0 sound, 1 there are errors, 2 there is no such file.

    Example: ntp check examples/block_stacking --static
    """
    paths = [find(file) for file in files]
    found: dict[Diagnostic, str | None] = {}  # with the text that each is about, each once
    for path in paths:
        report = diagnose(path)
        found |= {each: report.sources.get(each.span.path) for each in report.diagnostics}
    errors = sum(each.severity == "error" for each in found)
    if format is Format.JSON:
        from ntp_dsl.cli.display import print_json

        print_json({"sound": not errors, "diagnostics": [_row(each) for each in found]})
    else:
        _print_text(paths, found, errors)
    return int(errors > 0)


def _print_text(paths: list[Path], found: dict[Diagnostic, str | None], errors: int) -> None:
    for diagnostic, source in found.items():
        print(render(diagnostic, source), end="\n\n")
    if errors:
        print(f"{errors} mistake{'s' * (errors != 1)} found")
    else:
        print(f"sound: {', '.join(str(path) for path in paths)}")


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
