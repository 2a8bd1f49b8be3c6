"""Mistakes that repeat: then a declaration is as likely to be wrong as all that refers to it."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Hashable, Iterable, Mapping
from dataclasses import replace
from pathlib import Path

from ntp_dsl.language.diagnostics.diagnostics import Diagnostic

PROSE = re.compile(r'''"""[\s\S]*?"""|#[^\n]*''')


def doubt_repeated(diagnostics: Iterable[Diagnostic], sources: Mapping[Path | None, str]) -> list[Diagnostic]:
    """Return the diagnostics, with offers in place of fixes of what is written so again and again.

    A name that is used so more often than the one it is near to is probably right, and so are two calls with
    their arguments in another order than in the declaration.
    """
    found = list(diagnostics)
    counts = Counter(map(_mistake, found))
    return [
        replace(each, fix=replace(each.fix, certain=False))
        if each.fix is not None and _is_usual(each, counts[_mistake(each)], sources.get(each.span.path, ""))
        else each
        for each in found
    ]


def _mistake(diagnostic: Diagnostic) -> Hashable:
    """Return what is the same in mistakes that one wrong declaration explains."""
    fix = diagnostic.fix
    if fix is None or not fix.certain:
        return None
    if diagnostic.name:
        return diagnostic.name, fix.replacement
    is_order = diagnostic.code == "E202" and fix.replacement.endswith(")")
    return ("order", diagnostic.notes) if is_order else None


def _is_usual(diagnostic: Diagnostic, count: int, text: str) -> bool:
    fix = diagnostic.fix
    if fix is None or _mistake(diagnostic) is None or count < 2 or not text:
        return False
    if not diagnostic.name or diagnostic.name.lower() == fix.replacement.lower():
        return True
    return count >= len(re.findall(rf"\b{re.escape(fix.replacement)}\b", PROSE.sub("", text)))
