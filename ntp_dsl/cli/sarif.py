"""Diagnostics for other tools, as a SARIF 2.1.0 document."""

from __future__ import annotations

from collections.abc import Sequence
from importlib.metadata import version
from pathlib import Path
from typing import Any
from urllib.parse import quote

from ntp_dsl.language.diagnostics.codes import CODES
from ntp_dsl.language.diagnostics.diagnostics import Diagnostic, Edit, Fix
from ntp_dsl.language.syntax.nodes import Span

Json = dict[str, Any]

SCHEMA = "https://docs.oasis-open.org/sarif/sarif/v2.1.0/errata01/os/schemas/sarif-schema-2.1.0.json"


def document(diagnostics: Sequence[Diagnostic]) -> Json:
    """Return the document of one run of the checker; every code that occurs is a rule."""
    codes = sorted({each.code for each in diagnostics})
    driver = {
        "name": "ntp check",
        "version": version("ntp_dsl"),
        "rules": [{"id": code, "shortDescription": {"text": CODES.get(code, code)}} for code in codes],
    }
    results = [_result(each, codes.index(each.code)) for each in diagnostics]
    run = {
        "tool": {"driver": driver},
        "columnKind": "unicodeCodePoints",
        "results": results,
    }
    return {"$schema": SCHEMA, "version": "2.1.0", "runs": [run]}


def _result(diagnostic: Diagnostic, rule: int) -> Json:
    text = diagnostic.message + (f" ({diagnostic.help})" if diagnostic.help else "")
    text = "\n".join([text, *(note.message for note in diagnostic.notes if not note.span.line)])
    result: Json = {
        "ruleId": diagnostic.code,
        "ruleIndex": rule,
        "level": diagnostic.severity,
        "message": {"text": text},
        "locations": [_location(diagnostic.span)],
    }
    related = [
        {**_location(note.span), "message": {"text": note.message}}
        for note in diagnostic.notes
        if note.span.line
    ]
    if related:
        result["relatedLocations"] = related
    if diagnostic.fix is not None and diagnostic.fix.span.path is not None:
        result["fixes"] = [_fix(diagnostic.fix)]
    return result


def _location(span: Span) -> Json:
    if span.path is None:
        return {}
    location: Json = {"artifactLocation": _artifact(span.path)}
    if span.line:
        location["region"] = _region(span)
    return {"physicalLocation": location}


def _artifact(path: Path) -> Json:
    """Return the location of a file, relative to the working directory where it is inside."""
    path = path.resolve()
    if path.is_relative_to(Path.cwd()):
        return {"uri": quote(path.relative_to(Path.cwd()).as_posix())}
    return {"uri": path.as_uri()}


def _region(span: Span) -> Json:
    return {
        "startLine": span.line,
        "startColumn": span.column,
        "endLine": span.end_line,
        "endColumn": span.end_column,
    }


def _fix(fix: Fix) -> Json:
    changes: dict[Path, list[Edit]] = {}
    for edit in fix.edits:
        if edit.span.path is not None:
            changes.setdefault(edit.span.path, []).append(edit)
    text = "This is meant." if fix.certain else "This may be meant; ntp check --fix leaves it to you."
    return {
        "description": {"text": text},
        "artifactChanges": [
            {"artifactLocation": _artifact(path), "replacements": [*map(_replacement, edits)]}
            for path, edits in changes.items()
        ],
    }


def _replacement(edit: Edit) -> Json:
    return {
        "deletedRegion": _region(edit.span),
        "insertedContent": {"text": edit.replacement},
    }
