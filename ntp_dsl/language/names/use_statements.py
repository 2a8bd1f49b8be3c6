"""Checks of a `use` line by itself: whether there is such a library, and whether it is named once."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence

from ntp_dsl.language.diagnostics.diagnostics import Diagnostic, Fix, Note, unknown
from ntp_dsl.language.syntax.nodes import Library, Span, Use


def unknown_library(use: Use, known: Iterable[str]) -> Diagnostic:
    """Report a library that does not exist."""
    return unknown("E110", "there is no library", use.library, use.span, known)


def circular_use(use: Use, names: Sequence[str]) -> Diagnostic:
    """Report a library that is used by what it uses; `names` is the cycle from it to itself."""
    if len(names) <= 2:
        message = f"library '{names[0]}' uses itself"
        help = "it sees its own names anyway"
        return Diagnostic("E304", message, use.span, (), help, line_removal(use))
    message = f"libraries use one another in a circle: {' -> '.join(names)}"
    return Diagnostic("E304", message, use.span)


def repeated_uses(library: Library) -> Iterator[Diagnostic]:
    """Report each library that is used a second time."""
    first: dict[str, Use] = {}
    for use in library.uses:
        if use.library in first:
            note = Note("first used here", first[use.library].span)
            message = f"library '{use.library}' is used already"
            yield Diagnostic("W301", message, use.span, (note,), "", line_removal(use))
        first.setdefault(use.library, use)


def line_removal(use: Use) -> Fix:
    """Remove the line."""
    span = use.span
    return Fix(Span(span.path, span.line, 1, span.line + 1, 1), "")
