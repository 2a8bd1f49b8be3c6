"""What to say of a name that nobody declared: which library has it, or which name comes near."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from functools import cache

from ntp_dsl.language.diagnostics import Diagnostic, Fix, unknown
from ntp_dsl.language.names import SPACES, Table
from ntp_dsl.language.parser import parse
from ntp_dsl.language.syntax import Library, Span
from ntp_dsl.resources import library_folder


def report_unknown(
    table: Table,
    space: str,
    code: str,
    what: str,
    name: str,
    span: Span,
    candidates: Iterable[str],
    help: str = "",
    likely: Iterable[str] = (),
) -> None:
    """Say it once of each library that should be used, and of each other name where it stands.

    Args:
        space: the namespace to look in: type, value, predicate, call or task.
    """
    library = _standard_names().get((space, name))
    if library is None or table.home is None or table.home.name == library:
        table.mistakes.append(unknown(code, what, name, span, candidates, help, likely))
    elif library not in table.missing:
        table.missing.add(library)
        message = f"{what} '{name}': library '{library}' declares it, and is not used here"
        fix = _use(library, table.home)
        help = f"write 'use {library}' above, and what else it declares is there too"
        table.mistakes.append(Diagnostic(code, message, span, help=help, fix=fix))


@cache
def _standard_names() -> Mapping[tuple[str, str], str]:
    """Which standard library declares a name, by namespace and name."""
    found: dict[tuple[str, str], str] = {}
    for path in sorted(library_folder().glob("*.ntp")):
        library = parse(path.read_text(encoding="utf-8"), path)
        for declaration in library.declarations:
            found[SPACES[type(declaration)][1], declaration.name] = library.name
    return found


def _use(library: str, home: Library) -> Fix | None:
    """Below the last `use`, or above the first declaration."""
    if home.uses:
        last = home.uses[-1].span
        place = Span(last.path, last.line, last.end_column, last.line, last.end_column)
        return Fix(place, f"\nuse {library}")
    if not home.declarations:
        return None
    first = min((each.span for each in home.declarations), key=lambda span: span.line)
    return Fix(Span(first.path, first.line, 1, first.line, 1), f"use {library}\n\n")
