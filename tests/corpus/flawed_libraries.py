"""The corpus of flawed libraries: which diagnostics are expected, and how well they are found and fixed.

A library stands in a file as a user would write it. Below each mistake a comment marks the token at fault
and says what is expected of it; these comments are taken out before the library is checked:

    pick_an_place(p.item, p.support)
#   ^^^^^^^^^^^^^ E104 fix: pick_and_place         the code, and the first edit of the fix
#=      pick_and_place(p.item, p.support)          the line as `--fix` writes it; `#-` if it removes the line
progam stack(goal: list[Placement]):
#< E002 fix                                       a token at the margin; some fix, whatever it replaces
#=program stack(goal: list[Placement]):
    requires present(item)
#            ^^^^^^^ E403 offer                   only an offer, or `offer: TEXT`

A mistake without `fix` is one that `--fix` leaves alone.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from ntp_dsl.cli.mending import mend
from ntp_dsl.language.diagnostics.diagnostics import Diagnostic
from ntp_dsl.language.diagnostics.rendering import changed_lines
from ntp_dsl.language.loader import check_files

FOLDER = Path(__file__).parent / "flawed"
MARK = re.compile(r"#(?:<|( *)\^+) ([EWN]\d+)(?: (fix|offer))?(?:: (.*))?")
MEANT = re.compile(r"#(?:=(.*)|-)")


@dataclass(frozen=True)
class Expected:
    """A mistake, where it is, and what is proposed: a `fix`, an `offer`, or nothing certain."""

    code: str
    line: int
    column: int
    proposal: str | None
    replacement: str | None

    @property
    def has_fix(self) -> bool:
        return self.proposal == "fix"


@dataclass(frozen=True)
class Flawed:
    path: Path
    text: str
    expected: tuple[Expected, ...]
    meant: str  # the text with all that is certain mended

    @property
    def name(self) -> str:
        return f"{self.path.parent.name}/{self.path.stem}"


@dataclass(frozen=True)
class Score:
    """How well one expected mistake is found; `why` says what is missing."""

    caught: bool
    located: bool
    fixed: bool = False
    why: str = ""


@dataclass(frozen=True)
class Result:
    """How a flawed library was judged, and the lines that `--fix` wrote and nobody meant."""

    scores: tuple[Score, ...]
    wrong: tuple[str, ...]


def read_flawed(path: Path) -> Flawed:
    rows: list[str] = []
    meant: dict[int, str | None] = {}  # by the row's number, from one
    expected: list[Expected] = []
    for row in path.read_text(encoding="utf-8").split("\n"):
        if (mark := MARK.fullmatch(row)) is not None:
            indent, code, proposal, replacement = mark.groups()
            column = 1 if indent is None else len(indent) + 2
            text = replacement.replace("\\n", "\n") if replacement is not None else None
            expected.append(Expected(code, len(rows), column, proposal, text))
        elif expected and (mended := MEANT.fullmatch(row)) is not None:
            text = mended.group(1)
            meant[len(rows)] = text.replace("\\n", "\n") if text is not None else None
        else:
            rows.append(row)
    mended_rows = [meant.get(number, row) for number, row in enumerate(rows, start=1)]
    whole = "\n".join(row for row in mended_rows if row is not None)
    return Flawed(path, "\n".join(rows), tuple(expected), whole)


def corpus() -> list[Flawed]:
    return [read_flawed(path) for path in sorted(FOLDER.glob("*/*.ntp"))]


def judge(flawed: Flawed, folder: Path) -> Result:
    """Return how well each expected mistake is found, in the order of the text, and what is fixed wrongly."""
    path = folder / "library.ntp"
    path.write_text(flawed.text, encoding="utf-8")
    found = check_files(path).diagnostics
    mended = mend(lambda texts: check_files(path, texts).diagnostics, None, [path])
    text = mended.texts.get(path, flawed.text)
    written = [row for _, sign, row in changed_lines(flawed.text, text) if sign == "+"]
    removed = [row for _, sign, row in changed_lines(flawed.text, text) if sign == "-"]
    meant, kept = flawed.meant.split("\n"), flawed.text.split("\n")
    wrong = [row for row in written if row not in meant]
    wrong += [f"- {row}" for row in removed if row in meant and meant.count(row) == kept.count(row)]
    scores = [_score(each, found) for each in flawed.expected]
    if text != flawed.meant:
        scores = [
            replace(score, fixed=False, why=score.why or f"--fix leaves another text than is meant: {wrong}")
            if each.has_fix
            else score
            for score, each in zip(scores, flawed.expected, strict=True)
        ]
    return Result(tuple(scores), tuple(wrong))


def _score(expected: Expected, found: Sequence[Diagnostic]) -> Score:
    same = [each for each in found if each.code == expected.code]
    there = [each for each in same if (each.span.line, each.span.column) == (expected.line, expected.column)]
    if not there:
        seen = ", ".join(f"{each.code} {each.span.line}:{each.span.column}" for each in found)
        why = f"{expected.code} {expected.line}:{expected.column} expected, found: {seen or 'nothing'}"
        return Score(bool(same), False, why=why)
    fix = there[0].fix
    proposal = None if fix is None else "fix" if fix.certain else "offer"
    is_wanted = expected.proposal is None or proposal == expected.proposal
    if not is_wanted or (expected.proposal is None and proposal == "fix"):
        what = f"{proposal} {fix.replacement!r}" if fix else "nothing"
        why = f"{expected.code} comes with {what}, not with {expected.proposal or 'nothing certain'}"
        return Score(True, True, why=why)
    if fix is not None and expected.replacement not in (None, fix.replacement):
        why = f"{expected.code} is mended by {fix.replacement!r}, not {expected.replacement!r}"
        return Score(True, True, why=why)
    return Score(True, True, expected.has_fix)
