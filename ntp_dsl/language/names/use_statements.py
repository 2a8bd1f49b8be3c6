"""What can be wrong with a `use` line by itself: no such library, one named twice, or this one."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence

from ntp_dsl.language.diagnostics.diagnostics import Diagnostic, Fix, Note, unknown
from ntp_dsl.language.syntax.nodes import Library, Span, Use


def unknown_library(use: Use, known: Iterable[str]) -> Diagnostic:
    """For a library that is nowhere."""
    return unknown("E110", "there is no library", use.library, use.span, known)


def circle(use: Use, names: Sequence[str]) -> Diagnostic:
    """For a library that is used by what it uses; `names` go round from it to itself."""
    if len(names) <= 2:
        message = f"library '{names[0]}' uses itself"
        help = "it sees its own names anyway"
        return Diagnostic("E304", message, use.span, (), help, removal(use))
    message = f"libraries use one another in a circle: {' -> '.join(names)}"
    return Diagnostic("E304", message, use.span)


def repeated(library: Library) -> Iterator[Diagnostic]:
    """For each library that is used a second time."""
    first: dict[str, Use] = {}
    for use in library.uses:
        if use.library in first:
            note = Note("first used here", first[use.library].span)
            message = f"library '{use.library}' is used already"
            yield Diagnostic("W301", message, use.span, (note,), "", removal(use))
        first.setdefault(use.library, use)


def removal(use: Use) -> Fix:
    """Takes the line out."""
    span = use.span
    return Fix(Span(span.path, span.line, 1, span.line + 1, 1), "")
