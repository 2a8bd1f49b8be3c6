"""Diagnostics: what is wrong with a text, and where. All those of a library travel in one `SourceError`.

NtpError                   anything a user did that cannot work; the message is for the user
+-- SourceError            the text of a library is at fault; carries every diagnostic
+-- TaskFailed             the request was valid, and the answer is no
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path

from ntp_dsl.language.diagnostics.spelling import is_misspelt, nearest
from ntp_dsl.language.syntax.nodes import NOWHERE, Span

SEVERITIES = {"E": "error", "W": "warning", "N": "note"}


@dataclass(frozen=True)
class Edit:
    """Replace the text at `span` (none, where it is empty) by `replacement`."""

    span: Span
    replacement: str


@dataclass(frozen=True)
class Fix(Edit):
    """An edit that corrects a mistake, with those needed elsewhere; apply all `edits` or none.

    A fix is an offer, for a person to choose, unless it is certain: then `ntp check --fix` applies it. It
    is certain if the user would surely have written just that. What changes a number's value, an order or
    the logic, drops words with a meaning, or is one of several possibilities, is an offer.
    """

    also: tuple[Edit, ...] = ()
    certain: bool = field(default=False, kw_only=True)

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


def unknown(
    code: str,
    what: str,
    name: str,
    span: Span,
    candidates: Iterable[str],
    help: str = "",
    likely: Iterable[str] | None = None,
) -> Diagnostic:
    """Return the diagnostic for an unknown name, with the nearest known one as a fix.

    Args:
        likely: the candidates that would fit at the place; a near one among them comes first. None where
            all would.
    """
    known = sorted(set(candidates))
    fitting = known if likely is None else [*likely]
    meant = nearest(name, fitting) or nearest(name, known)
    if meant is not None:
        certain = meant in fitting and is_misspelt(name, meant, known)
        message = f"{what} '{name}'; did you mean '{meant}'?"
        return Diagnostic(code, message, span, (), help, Fix(span, meant, certain=certain), name)
    listing = ", ".join(known[:12]) + (", ..." if len(known) > 12 else "")
    help = help or (listing and f"there is: {listing}")
    return Diagnostic(code, f"{what} '{name}'", span, (), help, None, name)
