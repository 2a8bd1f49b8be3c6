"""Places of diagnostics: in the text that is checked, never in a library that ships with the package."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from dataclasses import replace
from pathlib import Path

from ntp_dsl.common.resources import examples_folder, library_folder
from ntp_dsl.language.diagnostics.diagnostics import Diagnostic, Note
from ntp_dsl.language.registry import Registry
from ntp_dsl.language.syntax.nodes import NOWHERE, Span
from ntp_dsl.tasks.instances import Instance


class Places:
    """The places of a library that its user can change.

    Args:
        path: of the library that is checked, which may be one that ships; None for a text in no file.
    """

    def __init__(self, registry: Registry, path: Path | None) -> None:
        self._registry, self._path = registry, path
        self._shipped = [folder.resolve() for folder in (library_folder(), examples_folder())]

    def is_own(self, span: Span) -> bool:
        """Return whether a place exists, and is not in a library that ships."""
        if span.path is None or span.path == self._path:
            return span.line > 0
        return not any(span.path.resolve().is_relative_to(folder) for folder in self._shipped)

    def innermost(self, way: Sequence[Span], home: Span) -> Span:
        """Return the last own place of those that lead to another; `home` where there is none."""
        return next((span for span in reversed(way) if self.is_own(span)), home)

    def scene(self, instance: Instance, names: Collection[object] = ()) -> Span:
        """Return the line of a scene that declares one of some objects, or else its first line."""
        groups = instance.task.scene
        objects = {each for each in names if isinstance(each, str)}
        for group in groups:
            members = instance.bindings.get(group.name)
            if isinstance(members, tuple) and not objects.isdisjoint(map(str, members)):
                return group.span
        return groups[0].span if groups else self.anywhere

    def owned(self, diagnostic: Diagnostic, home: Span) -> Diagnostic:
        """Return the diagnostic at its own place, or at `home`, with a note at the place in what ships."""
        if self.is_own(diagnostic.span):
            return diagnostic
        own = home if self.is_own(home) else self.anywhere
        if not own.line:
            return diagnostic  # there is no text but what ships
        notes = [Note("in a library that is used", diagnostic.span)] if diagnostic.span.line else []
        return replace(diagnostic, span=own, notes=(*notes, *diagnostic.notes))

    @property
    def anywhere(self) -> Span:
        """Return the first scene, program, api or predicate that is own, or else where the file begins."""
        beginning = Span(self._path, 1, 1, 1, 1) if self._path is not None else NOWHERE
        return next(filter(self.is_own, self._declared()), beginning)

    def _declared(self) -> Iterator[Span]:
        registry = self._registry
        yield from (group.span for task in registry.tasks.values() for group in task.scene)
        yield from (row.span for rows in (registry.programs, registry.apis) for row in rows.values())
        yield from (declared.name_span for declared in registry.predicates.values())
