"""Diagnostics: what is wrong with a text, and where. All those of a library travel in one `SourceError`.

NtpError                   anything a user did that cannot work; the message is for the user
+-- SourceError            the text of a library is at fault; carries every diagnostic
+-- TaskFailed             the request was valid, and the answer is no
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from difflib import SequenceMatcher, get_close_matches
from pathlib import Path

from ntp_dsl.language.syntax.nodes import NOWHERE, Span

SEVERITIES = {"E": "error", "W": "warning", "N": "note"}


@dataclass(frozen=True)
class Edit:
    """Replace the text at `span` (none, where it is empty) by `replacement`."""

    span: Span
    replacement: str


@dataclass(frozen=True)
class Fix(Edit):
    """An edit that corrects a mistake, with those needed elsewhere; apply all `edits` or none."""

    also: tuple[Edit, ...] = ()

    @property
    def edits(self) -> tuple[Edit, ...]:
        return Edit(self.span, self.replacement), *self.also


@dataclass(frozen=True)
class Note:
    """A related place: "declared here"."""

    message: str
    span: Span = NOWHERE


@dataclass(frozen=True)
class Diagnostic:
    """An error, a warning or a note, with a stable code.

    E0 is syntax, E1 names, E2 types, E3 duplicates and circles, E4 contracts, E5 tasks.
    """

    code: str
    message: str
    span: Span
    notes: tuple[Note, ...] = ()
    help: str = ""
    fix: Fix | None = None
    name: str = ""  # the unknown name, where the diagnostic is about one

    @property
    def severity(self) -> str:
        return SEVERITIES[self.code[0]]

    def __str__(self) -> str:
        return f"{self.span}: {self.severity}[{self.code}]: {self.message}"


class NtpError(Exception):
    """The base of every error that is meant for the user: a plain sentence, never a traceback."""


class TaskFailed(NtpError):
    """A valid request failed: the tower does not stand, nothing was recorded."""


class SourceError(NtpError):
    """A library has errors; `diagnostics` holds everything that is wrong with it."""

    def __init__(
        self, diagnostics: Iterable[Diagnostic], sources: Mapping[Path | None, str] | None = None
    ) -> None:
        self.diagnostics = in_order(diagnostics)
        self.sources = dict(sources or {})
        super().__init__(self.diagnostics)

    def __str__(self) -> str:
        """Return a line for each; `rendering.render` shows the source as well."""
        return "\n".join(map(str, self.diagnostics))


def in_order(diagnostics: Iterable[Diagnostic]) -> tuple[Diagnostic, ...]:
    """Return the diagnostics by path, line, column and code."""
    return tuple(sorted(diagnostics, key=_place))


def _place(diagnostic: Diagnostic) -> tuple[str, int, int, str]:
    span = diagnostic.span
    return str(span.path or ""), span.line, span.column, diagnostic.code


def has_errors(diagnostics: Iterable[Diagnostic]) -> bool:
    """Return whether any of the diagnostics is an error."""
    return any(each.severity == "error" for each in diagnostics)


def nearest(name: str, candidates: Iterable[str]) -> str | None:
    """Return what was probably meant, if anything is near: another case, few typing errors, a part of it."""
    known = sorted(set(candidates))
    alike = [each for each in known if _folded(each) == _folded(name)]
    if len(alike) == 1:
        return alike[0]
    distances = {
        each: count
        for each in known
        if (count := _edit_distance(name.lower(), each.lower(), max(len(name), len(each)) // 3)) is not None
    }
    if distances:
        return min(distances, key=lambda each: (distances[each], -_ratio(name, each)))
    found = get_close_matches(name, known, n=1, cutoff=0.6)
    return found[0] if found else None


def _folded(name: str) -> str:
    return name.lower().replace("_", "")


def _ratio(name: str, other: str) -> float:
    return SequenceMatcher(None, name, other).ratio()


def _edit_distance(name: str, other: str, most: int) -> int | None:
    """Count letters to add, drop, replace, or swap with a neighbour (optimal string alignment).

    None where it takes more than `most`.
    """
    if abs(len(name) - len(other)) > most or len(set(name) ^ set(other)) > 2 * most:
        return None  # the quick answer, for libraries of thousands of names
    second_last: list[int] = []
    last = list(range(len(other) + 1))
    for i, letter in enumerate(name, start=1):
        row = [i]
        for j, wanted in enumerate(other, start=1):
            cost = min(last[j] + 1, row[j - 1] + 1, last[j - 1] + (letter != wanted))
            if i > 1 and j > 1 and letter == other[j - 2] and name[i - 2] == wanted:
                cost = min(cost, second_last[j - 2] + 1)
            row.append(cost)
        second_last, last = last, row
    return last[-1] if last[-1] <= most else None


def unknown(
    code: str,
    what: str,
    name: str,
    span: Span,
    candidates: Iterable[str],
    help: str = "",
    likely: Iterable[str] = (),
) -> Diagnostic:
    """Return the diagnostic for an unknown name, with the nearest known one as a fix.

    Args:
        likely: the candidates that would fit at the place; a near one among them comes first.
    """
    known = sorted(set(candidates))
    meant = nearest(name, likely) or nearest(name, known)
    if meant is not None:
        message = f"{what} '{name}'; did you mean '{meant}'?"
        return Diagnostic(code, message, span, (), help, Fix(span, meant), name)
    listing = ", ".join(known[:12]) + (", ..." if len(known) > 12 else "")
    help = help or (listing and f"there is: {listing}")
    return Diagnostic(code, f"{what} '{name}'", span, (), help, None, name)
