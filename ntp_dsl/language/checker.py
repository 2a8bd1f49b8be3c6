"""From libraries to a registry, or to every diagnostic at once."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property, partial
from pathlib import Path

from ntp_dsl.language.checks.build_registry import build_registry
from ntp_dsl.language.checks.check_library import examine
from ntp_dsl.language.diagnostics.diagnostics import Diagnostic, SourceError, has_errors, in_order
from ntp_dsl.language.diagnostics.rendering import plain, render
from ntp_dsl.language.diagnostics.repetition import doubt_repeated
from ntp_dsl.language.names.incremental_cache import IncrementalCache
from ntp_dsl.language.names.unknown_names import AvailableNames, standard_names
from ntp_dsl.language.names.use_statements import unknown_library
from ntp_dsl.language.names.visibility import Unit
from ntp_dsl.language.parsing.partial_library import PartialLibrary
from ntp_dsl.language.registry import Registry
from ntp_dsl.language.syntax.nodes import Library


@dataclass(frozen=True, repr=False)
class Report:
    """The diagnostics of a library and of those it uses, and its registry if there is no error."""

    diagnostics: tuple[Diagnostic, ...]  # in the order of the texts
    sources: Mapping[Path | None, str]  # every text that was read, by its path
    build: Callable[[], Registry] | None = field(compare=False, repr=False)

    @property
    def is_sound(self) -> bool:
        return self.build is not None

    @cached_property
    def registry(self) -> Registry | None:
        """The checked library; None where there is an error."""
        return self.build() if self.build else None

    def checked(self) -> Registry:
        """Return the registry; raise `SourceError` with every diagnostic where there is an error."""
        if self.registry is None:
            raise SourceError(self.diagnostics, self.sources)
        return self.registry

    def __repr__(self) -> str:
        """Return the diagnostics as the terminal shows them, without its colours."""
        if not self.diagnostics:
            return "<Report: nothing to say>"
        return "\n".join(plain(render(each, self.sources)) for each in self.diagnostics)


def check(*libraries: Library, sources: Mapping[Path | None, str] | None = None) -> Registry:
    """Check a library together with those it uses; `SourceError` carries every diagnostic.

    Args:
        libraries: the library that the registry is named after, then the libraries that it uses.
        sources: texts by path, for the excerpts in the error's message.
    """
    units, found = link([PartialLibrary(library) for library in libraries])
    return check_units(units, found, sources or {}).checked()


def link(libraries: Sequence[PartialLibrary]) -> tuple[list[Unit], list[Diagnostic]]:
    """Find what each library uses among the others, by name."""
    known = {each.library.name: index for index, each in reversed([*enumerate(libraries)])}
    units: list[Unit] = []
    found: list[Diagnostic] = []
    for each in libraries:
        used: list[int | None] = []
        for use in each.library.uses:
            meant = use.library
            if meant not in known:
                wrong = unknown_library(use, known)
                found.append(wrong)
                meant = wrong.fix.replacement if wrong.fix else ""
            used.append(known.get(meant))
        units.append(Unit(each, tuple(used)))
    return units, found


def check_units(
    units: Sequence[Unit],
    found: Iterable[Diagnostic],
    sources: Mapping[Path | None, str],
    available: AvailableNames = standard_names,
    cache: IncrementalCache | None = None,
) -> Report:
    """Check the meaning of a library and of all that it uses.

    Args:
        units: the library in question first.
        found: what is wrong with their form.
        available: where else a name may be declared.
        cache: of earlier checks.
    """
    table, wrong = examine(units, available, cache)
    diagnostics = in_order(doubt_repeated([*found, *wrong], sources))
    is_sound = not has_errors(diagnostics)
    build = partial(build_registry, units[0].library.name, table) if is_sound else None
    return Report(diagnostics, sources, build)
