"""Applies the fixes of diagnostics to files, and checks the files again."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path

from ntp_dsl.common.files import rewrite
from ntp_dsl.common.resources import library_folder
from ntp_dsl.language.diagnostics.apply_fixes import apply_fixes
from ntp_dsl.language.diagnostics.diagnostics import Diagnostic
from ntp_dsl.language.diagnostics.rendering import Line, Style, changed_lines, shown_path
from ntp_dsl.language.loader import read

Texts = Mapping[Path, str]


def fixed_texts(diagnostics: Sequence[Diagnostic], named: Iterable[Path]) -> Texts:
    """Return the files that the fixes would change, each with its new text.

    The standard library is not changed, unless its files are named.
    """
    paths = dict.fromkeys(each.fix.span.path for each in diagnostics if each.fix is not None)
    texts: dict[Path, str] = {}
    for path in paths:
        if path is None or path not in named and path.parent == library_folder():
            continue
        before = read(path)
        after = apply_fixes(before, diagnostics, path)
        if after != before:
            texts[path] = after
    return texts


def fix_files(examine: Callable[[], Sequence[Diagnostic]], named: Iterable[Path]) -> Texts:
    """Apply fixes and check again until none is left; return the previous texts of the files."""
    before: dict[Path, str] = {}
    seen: set[tuple[tuple[Path, str], ...]] = set()  # fixes that undo each other return to one
    while True:
        after = fixed_texts(examine(), named)
        state = tuple(sorted(after.items()))
        if not after or state in seen:
            return before
        seen.add(state)
        for path, text in after.items():
            before.setdefault(path, read(path))
            rewrite(path, text)


def difference(path: Path, before: str, after: str) -> list[Line]:
    """Return the lines of a file that differ, with their numbers."""
    changes = list(changed_lines(before, after))
    margin = max(len(str(number)) for number, _, _ in changes)
    lines: list[Line] = [((f"{shown_path(path)}:", Style.STRONG),)]
    for number, sign, row in changes:
        style = Style.ADDED if sign == "+" else Style.REMOVED
        text = row.rstrip("\r")
        lines.append(((f" {number:>{margin}} ", Style.FRAME), (f"{sign} {text}", style)))
    return [*lines, ()]
