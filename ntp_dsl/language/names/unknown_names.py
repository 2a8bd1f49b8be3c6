"""Unknown names: those that unreadable text may declare are dropped, others are sought in other libraries."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import cache
from pathlib import Path

from ntp_dsl.common.resources import library_folder
from ntp_dsl.language.diagnostics.diagnostics import Diagnostic, Fix
from ntp_dsl.language.names.visibility import Unit, dependencies, key
from ntp_dsl.language.parsing.blocks import DECLARES, NAMESPACES
from ntp_dsl.language.parsing.partial_library import Key
from ntp_dsl.language.syntax.nodes import EnumDeclaration, Library, Span

AvailableNames = Callable[[], Mapping[Key, str]]  # the library at hand that declares a name

# The namespaces in which a name was looked up, by the code that reports it as unknown.
NAMESPACES_BY_CODE: Mapping[str, tuple[str, ...]] = {
    "E101": ("value", "type"),
    "E102": ("predicate",),
    "E103": ("type",),
    "E104": ("call",),
    "E106": ("value", "type"),
    "E108": ("type",),
    "E111": ("predicate",),
}


def resolve_unknown(
    found: Iterable[Diagnostic], units: Sequence[Unit], index: int, available: AvailableNames
) -> Iterator[Diagnostic]:
    """Yield the diagnostics of a library that remain once all libraries are known.

    A name that an unreadable declaration may declare is passed over, and so is every diagnostic in a guessed
    line; that a library ought to be used is reported once.
    """
    home = units[index]
    inside = [*dependencies(units, index), index]
    unreadable = frozenset[Key]().union(*(units[each].partial.unreadable for each in inside))
    is_open = any(units[each].partial.lacks_uses or None in units[each].uses for each in inside)
    missing: set[str] = set()
    for each in found:
        if each.span.line in home.partial.guessed and each.span.path == home.library.path:
            continue
        keys = [(space, each.name) for space in NAMESPACES_BY_CODE.get(each.code, ()) if each.name]
        if keys and (is_open or not unreadable.isdisjoint(keys)):
            continue
        library = _owner(keys, units, inside, available) if keys else None
        if library is None:
            yield each
        elif library not in missing:
            missing.add(library)
            yield _not_used_here(each, library, home.library)


def _owner(
    keys: Sequence[Key], units: Sequence[Unit], inside: Sequence[int], available: AvailableNames
) -> str | None:
    """Return the library that declares one of the keys and is not visible."""
    for each, unit in enumerate(units):
        if each not in inside and not _declared(unit.library).isdisjoint(keys):
            return unit.library.name
    names = {unit.library.name for unit in units}
    known = available()
    return next((known[each] for each in keys if known.get(each, "") not in {"", *names}), None)


def _declared(library: Library) -> set[Key]:
    enums = (each for each in library.declarations if isinstance(each, EnumDeclaration))
    members = {("value", member) for enum in enums for member in enum.members}
    return members.union(map(key, library.declarations))


def _not_used_here(diagnostic: Diagnostic, library: str, home: Library) -> Diagnostic:
    message = f"'{diagnostic.name}' is declared by library '{library}', which is not used here"
    help = f"write 'use {library}' above, which makes its other names visible, too"
    return replace(diagnostic, message=message, help=help, fix=_use(library, home))


def _use(library: str, home: Library) -> Fix | None:
    """Write the `use` with the others, or above the first declaration."""
    nodes = [*home.uses, *home.declarations]
    if not nodes:
        return None
    first = nodes[0].span
    ending = "\n" if home.uses else "\n\n"
    is_standard = library in standard_names().values()  # a library beside it may be there for another purpose
    place = Span(first.path, first.line, 1, first.line, 1)
    return Fix(place, f"use {library}{ending}", certain=is_standard)


def names_in(paths: Iterable[Path]) -> Mapping[Key, str]:
    """Return which of the library files declares a name, as far as the first words of lines tell."""
    found: dict[Key, str] = {}
    for path in paths:
        try:
            text = path.read_text(encoding="utf-8")
        except (OSError, UnicodeDecodeError):
            continue
        for keyword, name in DECLARES.findall(text):
            found.setdefault((NAMESPACES[keyword], name), path.stem)
    return found


@cache
def standard_names() -> Mapping[Key, str]:
    """Return which standard library declares a name."""
    return names_in(sorted(library_folder().glob("*.ntp")))
