"""Mistakes that repeat: then a declaration is as likely to be wrong as all that refers to it."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import replace
from pathlib import Path

from ntp_dsl.language.diagnostics.diagnostics import Diagnostic

SWAPPED = "E202"
PROSE = re.compile(r'''"""[\s\S]*?"""|#[^\n]*''')


def doubt_repeated(diagnostics: Iterable[Diagnostic], sources: Mapping[Path | None, str]) -> list[Diagnostic]:
    """Return the diagnostics, with offers in place of fixes of what is written so again and again.

    A name that occurs more often than the one it is near to is probably right, and so are two calls of which
    the arguments are in another order than in the declaration.
    """
    found = list(diagnostics)
    swaps = Counter(each.notes for each in found if _is_swap(each))
    return [
        replace(each, fix=replace(each.fix, certain=False))
        if each.fix is not None
        and each.fix.certain
        and (swaps[each.notes] > 1 if _is_swap(each) else _is_usual(each, sources.get(each.span.path, "")))
        else each
        for each in found
    ]


def _is_swap(diagnostic: Diagnostic) -> bool:
    """Return whether the fix is a call with its arguments in another order."""
    fix = diagnostic.fix
    is_call = fix is not None and fix.certain and fix.replacement.endswith(")")
    return diagnostic.code == SWAPPED and is_call and bool(diagnostic.notes)


def _is_usual(diagnostic: Diagnostic, text: str) -> bool:
    fix = diagnostic.fix
    if not diagnostic.name or fix is None or not fix.replacement.isidentifier():
        return False
    if diagnostic.name == fix.replacement.lower():
        return False  # `mug` for `Mug`: in its other places, it is another kind of name
    code = PROSE.sub("", text)
    written, meant = (len(re.findall(rf"\b{word}\b", code)) for word in (diagnostic.name, fix.replacement))
    return written > meant > 0
