"""From libraries to the texts that `ntp check --fix` writes: certain fixes, as far as they worsen nothing."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from difflib import SequenceMatcher
from pathlib import Path

from ntp_dsl.common.resources import library_folder
from ntp_dsl.language.diagnostics.apply_fixes import apply_fixes
from ntp_dsl.language.diagnostics.diagnostics import Diagnostic, Fix, has_errors
from ntp_dsl.language.diagnostics.rendering import changed_lines, shown_path
from ntp_dsl.language.loader import read

Texts = Mapping[Path, str]
Examine = Callable[[Texts], Sequence[Diagnostic]]  # given the texts that replace those of files

TELLING = ("E0", "E1", "E2", "E3", "W4")  # families of diagnostics that speak against a fix


@dataclass(frozen=True)
class Mended:
    """The new text of every file that changes, and a sentence on each fix that was taken back."""

    texts: Texts
    taken_back: tuple[str, ...] = ()


def mend(examine: Examine, simulate: Examine | None, named: Iterable[Path]) -> Mended:
    """Apply the certain fixes until none is left; take back those with which the library is worse.

    Args:
        simulate: the dynamic check of libraries whose text has no errors.
        named: files that may be changed, though they are of the standard library.
    """
    mending = _Mending(examine, frozenset(named))
    while mending.apply_round():
        pass
    if simulate is not None:
        mending.take_back_what_fails(simulate)
    return Mended({p: t for p, t in mending.texts.items() if t != read(p)}, tuple(mending.taken_back))


class _Mending:
    """The texts so far, and the fixes that were tried and taken back."""

    def __init__(self, examine: Examine, named: frozenset[Path]) -> None:
        self._examine = examine
        self._named = named
        self._refused: set[tuple[Path | None, str, str]] = set()
        self._seen: set[tuple[tuple[Path, str], ...]] = set()  # fixes that undo each other return to one
        self.texts: dict[Path, str] = {}
        self.taken_back: dict[str, None] = {}

    def apply_round(self) -> bool:
        """Apply all fixes that are certain now; return whether there were any."""
        found = self._examine(self.texts)
        fixes = [fix for fix in dict.fromkeys(each.fix for each in found) if fix and self._may_apply(fix)]
        after = self._with(fixes)
        is_worse = bool(_worsened(found, self._examine(after)))
        suspects = [fix for fix in fixes if is_worse or _is_of_form(fix, found)]
        refused = [fix for fix in suspects if self._refuse(fix, found)]
        if refused:
            fixes = [fix for fix in fixes if fix not in refused]
            after = self._with(fixes)
        state = tuple(sorted(after.items()))
        if after == self.texts or state in self._seen:
            return False
        self._seen.add(state)
        self.texts = after
        return True

    def take_back_what_fails(self, simulate: Examine) -> None:
        """Restore the lines in which the simulation finds an error that was not there."""
        before: Sequence[Diagnostic] = ()
        was_sound = not has_errors(self._examine({}))
        if self.texts and was_sound:
            before = simulate({})
        while self._changed_files() and not has_errors(self._examine(self.texts)):
            changed = self._changed(self.texts, {path: read(path) for path in self.texts})
            new = [each for each in simulate(self.texts) if each.severity == "error" and each not in before]
            blamed = [each for each in new if _places(each) & changed]
            if not blamed and not (new and was_sound):
                return
            for each in blamed or new[:1]:
                places = _places(each) & changed if blamed else changed
                self._restore(places, f"in the simulation: {each.message} [{each.code}]")

    def _may_apply(self, fix: Fix) -> bool:
        path = fix.span.path
        is_own = path is not None and (path in self._named or path.parent != library_folder())
        return fix.certain and is_own and self._key(fix) not in self._refused

    def _key(self, fix: Fix) -> tuple[Path | None, str, str]:
        return fix.span.path, self._row(fix), fix.replacement

    def _row(self, fix: Fix) -> str:
        assert fix.span.path is not None
        rows = self._text(fix.span.path).split("\n")
        return rows[min(fix.span.line, len(rows)) - 1].strip()

    def _text(self, path: Path) -> str:
        return self.texts[path] if path in self.texts else read(path)

    def _with(self, fixes: Sequence[Fix]) -> dict[Path, str]:
        texts = dict(self.texts)
        for path in dict.fromkeys(fix.span.path for fix in fixes):
            if path is not None:
                texts[path] = apply_fixes(self._text(path), fixes, path)
        return texts

    def _refuse(self, fix: Fix, found: Sequence[Diagnostic]) -> bool:
        """Return whether the fix by itself makes the library worse."""
        after = self._with([fix])
        left = self._examine(after)
        worse = _worsened(found, left)
        if _is_of_form(fix, found):  # then mistakes of other lines were hidden, and the line must be read now
            changed = self._changed(after)
            unread = [each for each in left if each.code[:2] == "E0" or each.code == "E110"]
            here = [each for each in [*worse, *unread] if (each.span.path, each.span.line) in changed]
            worse = [each for each in here if each.fix is None or not each.fix.certain]
        if worse:
            self._refused.add(self._key(fix))
            assert fix.span.path is not None
            place = f"{shown_path(fix.span.path)}:{fix.span.line}"
            self._tell(place, self._row(fix), f"{worse[0].message} [{worse[0].code}]")
        return bool(worse)

    def _tell(self, place: str, row: str, why: str) -> None:
        self.taken_back[f"a fix was taken back at {place} ({row}); with it, {why}"] = None

    def _changed(self, after: Texts, before: Texts | None = None) -> set[tuple[Path, int]]:
        """Return the lines of the new texts that differ."""
        old = self.texts if before is None else before
        return {
            (path, number)
            for path, text in after.items()
            for number, sign, _ in changed_lines(old[path] if path in old else read(path), text)
            if sign == "+"
        }

    def _changed_files(self) -> bool:
        return any(text != read(path) for path, text in self.texts.items())

    def _restore(self, places: Iterable[tuple[Path, int]], why: str) -> None:
        """Restore the user's text where the lines are, each with the lines that changed together with it."""
        by_path: dict[Path, set[int]] = {}
        for path, number in places:
            by_path.setdefault(path, set()).add(number)
        for path, numbers in by_path.items():
            old, new = read(path).split("\n"), self.texts[path].split("\n")
            rows: list[str] = []
            for tag, i1, i2, j1, j2 in SequenceMatcher(None, old, new, autojunk=False).get_opcodes():
                is_restored = tag != "equal" and not numbers.isdisjoint(range(j1 + 1, j2 + 1))
                rows += old[i1:i2] if is_restored else new[j1:j2]
                if is_restored:
                    self._tell(f"{shown_path(path)}:{i1 + 1}", " ".join(old[i1:i2]).strip(), why)
            self.texts[path] = "\n".join(rows)


def _worsened(before: Sequence[Diagnostic], after: Sequence[Diagnostic]) -> list[Diagnostic]:
    """Return what is wrong now with form, names or types, was not before, and has no certain fix itself.

    A contract that is not kept says nothing about a fix: an unknown name hides it.
    """
    known = Counter((each.code, each.message) for each in before)
    worse: list[Diagnostic] = []
    for each in after:
        known[each.code, each.message] -= 1
        is_mended = each.fix is not None and each.fix.certain
        is_telling = each.code[:2] in TELLING and each.code != "E203"  # a number out of its range
        if known[each.code, each.message] < 0 and is_telling and not is_mended:
            worse.append(each)
    return worse


def _is_of_form(fix: Fix, found: Sequence[Diagnostic]) -> bool:
    """Return whether it is the fix of a line that does not parse."""
    return all(each.code.startswith("E0") for each in found if each.fix == fix)


def _places(diagnostic: Diagnostic) -> set[tuple[Path, int]]:
    spans = [diagnostic.span, *(note.span for note in diagnostic.notes)]
    return {
        (span.path, number)
        for span in spans
        if span.path is not None
        for number in range(span.line, span.end_line + 1)
    }
