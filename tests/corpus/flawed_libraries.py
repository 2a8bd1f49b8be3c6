"""The corpus of flawed libraries: which diagnostics are expected, and how well they are found and fixed.

A library stands in a file as a user would write it. Below each mistake a comment marks the token at fault
and says what is expected of it; these comments are taken out before the library is checked:

    pick_an_place(p.item, p.support)
#   ^^^^^^^^^^^^^ E104 fix: pick_and_place      the code, and the first edit of the fix
progam stack(goal: list[Placement]):
#< E002 fix                                    a token at the margin; some fix, whatever it replaces
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

from ntp_dsl.language.diagnostics.apply_fixes import apply_fixes
from ntp_dsl.language.diagnostics.diagnostics import Diagnostic
from ntp_dsl.language.loader import diagnose

FOLDER = Path(__file__).parent / "flawed"
MARK = re.compile(r"#(?:<|( *)\^+) ([EWN]\d+)( fix)?(?:: (.*))?")


@dataclass(frozen=True)
class Expected:
    """A mistake, where it is, and its fix, if there is a certain one."""

    code: str
    line: int
    column: int
    has_fix: bool
    replacement: str | None


@dataclass(frozen=True)
class Flawed:
    path: Path
    text: str
    expected: tuple[Expected, ...]

    @property
    def name(self) -> str:
        return f"{self.path.parent.name}/{self.path.stem}"


@dataclass(frozen=True)
class Score:
    """How well one expected mistake is found; `why` says what is missing."""

    caught: bool
    located: bool
    fixed: bool
    why: str = ""


def read_flawed(path: Path) -> Flawed:
    rows: list[str] = []
    expected: list[Expected] = []
    for row in path.read_text(encoding="utf-8").split("\n"):
        mark = MARK.fullmatch(row)
        if mark is None:
            rows.append(row)
            continue
        indent, code, fix, replacement = mark.groups()
        column = 1 if indent is None else len(indent) + 2
        meant = replacement.replace("\\n", "\n") if replacement is not None else None
        expected.append(Expected(code, len(rows), column, fix is not None, meant))
    return Flawed(path, "\n".join(rows), tuple(expected))


def corpus() -> list[Flawed]:
    return [read_flawed(path) for path in sorted(FOLDER.glob("*/*.ntp"))]


def found_in(text: str, folder: Path) -> Sequence[Diagnostic]:
    """Return the diagnostics of a library of that text."""
    path = folder / "library.ntp"
    path.write_text(text, encoding="utf-8")
    return diagnose(path).diagnostics


def scores(flawed: Flawed, folder: Path) -> list[Score]:
    """Return how well each expected mistake is found, in the order of the text."""
    found = found_in(flawed.text, folder)
    return [_score(each, found, flawed, folder) for each in flawed.expected]


def _score(expected: Expected, found: Sequence[Diagnostic], flawed: Flawed, folder: Path) -> Score:
    same = [each for each in found if each.code == expected.code]
    there = [each for each in same if (each.span.line, each.span.column) == (expected.line, expected.column)]
    if not there:
        seen = ", ".join(f"{each.code} {each.span.line}:{each.span.column}" for each in found)
        why = f"{expected.code} {expected.line}:{expected.column} expected, found: {seen or 'nothing'}"
        return Score(bool(same), False, False, why)
    fixed, why = _fixed(there[0], found, flawed, folder)
    if expected.has_fix and not fixed:
        why = why or f"{expected.code} comes without a fix"
    if fixed and expected.replacement is not None:
        fix = there[0].fix
        assert fix is not None
        if fix.replacement != expected.replacement:
            why = f"{expected.code} is mended by {fix.replacement!r}, not {expected.replacement!r}"
    return Score(True, True, fixed, why)


def _fixed(
    diagnostic: Diagnostic, found: Sequence[Diagnostic], flawed: Flawed, folder: Path
) -> tuple[bool, str]:
    """Return whether the fix leaves a sound library, or one with fewer diagnostics and no new ones."""
    if diagnostic.fix is None:
        return False, ""
    path = folder / "library.ntp"
    left = _serious(found_in(apply_fixes(flawed.text, [diagnostic], path), folder))
    found = _serious(found)
    new = _codes(left) - _codes(found)
    if new or len(left) >= len(found):
        codes = ", ".join(f"{each.code} {each.span.line}:{each.span.column}" for each in left)
        return False, f"the fix of {diagnostic.code} leaves: {codes}"
    if len(flawed.expected) == 1 and left:
        return False, f"the fix of {diagnostic.code} leaves {sorted(_codes(left))}"
    return True, ""


def _serious(diagnostics: Sequence[Diagnostic]) -> list[Diagnostic]:
    """Leave out unused declarations, of which the libraries of the corpus have some."""
    return [each for each in diagnostics if not each.code.startswith(("W1", "N1"))]


def _codes(diagnostics: Iterable[Diagnostic]) -> set[str]:
    return {each.code for each in diagnostics}
