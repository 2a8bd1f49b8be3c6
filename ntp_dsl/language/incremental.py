"""Checks libraries repeatedly while they are edited, and repeats only the work that an edit concerns.

Each declaration's text is parsed once, as if it were on lines of its own far below any file; spans are moved
to where the declaration is now.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Mapping
from dataclasses import fields, is_dataclass, replace
from pathlib import Path
from typing import Any, TypeVar

from ntp_dsl.language.diagnostics.diagnostics import in_order
from ntp_dsl.language.loader import Report, check_files
from ntp_dsl.language.names.incremental_cache import IncrementalCache
from ntp_dsl.language.parsing.blocks import Block
from ntp_dsl.language.parsing.parsed import Parsed
from ntp_dsl.language.parsing.parser import parse_block, read
from ntp_dsl.language.parsing.partial_library import PartialLibrary
from ntp_dsl.language.syntax.nodes import Span

FAR = 1_000_000_000  # the first line that belongs to no file

T = TypeVar("T")
Place = tuple[Path | None, str, int]  # a text, and how many equal ones there are above it in the file


class Session:
    """Keeps what was parsed and found to be sound, from one check to the next."""

    def __init__(self) -> None:
        self._cache = IncrementalCache()
        self._known: dict[Place, Parsed] = {}
        self._free = FAR

    def diagnose(self, path: Path, texts: Mapping[Path, str] | None = None) -> Report:
        """Check a file and all that it uses, with the same report as the loader's `diagnose`.

        Args:
            texts: of files as they are edited, in place of what is on the disk.
        """
        self._cache.begin()
        visit = _Visit(self)
        edited = dict[Path | None, str]((texts or {}).items())
        report = check_files(path, edited, visit.read, self._cache)
        self._known = visit.seen
        build = report.build
        return Report(
            in_order(map(visit.moved, report.diagnostics)),
            report.sources,
            (lambda: visit.moved(build())) if build else None,
        )

    def parsed(self, place: Place, block: Block) -> Parsed:
        """Return the block as it was parsed before, or parse it now."""
        if place not in self._known:
            self._known[place] = parse_block(replace(block, line=self._free))
            self._free += block.text.count("\n") + 1
        return self._known[place]


class _Visit:
    """One check: the blocks that were read, and where they are."""

    def __init__(self, session: Session) -> None:
        self._session = session
        self.seen: dict[Place, Parsed] = {}
        self._lines: list[tuple[int, int]] = []  # the first line far below, and the one in the file

    def read(self, text: str, path: Path | None) -> PartialLibrary:
        """Read a library as the parser does, with the blocks that are known already."""
        counts: dict[str, int] = {}

        def read_block(block: Block) -> Parsed:
            if block.diagnostics:
                return parse_block(block)
            counts[block.text] = counts.get(block.text, 0) + 1
            place = path, block.text, counts[block.text]
            parsed = self.seen[place] = self._session.parsed(place, block)
            self._lines.append((parsed.block.line, block.line))
            return parsed

        partial = read(text, path, read_block)
        self._lines.sort()
        return partial

    def moved(self, value: T) -> T:
        """Return a diagnostic, or anything else with spans, with all spans as they are in the files."""
        return self._moved(value)  # type: ignore[no-any-return]

    def _moved(self, value: Any) -> Any:
        if isinstance(value, Span):
            return self._place(value)
        if isinstance(value, tuple):
            return tuple(map(self._moved, value))
        if isinstance(value, dict):
            return {key: self._moved(each) for key, each in value.items()}
        if is_dataclass(value) and not isinstance(value, type):
            return replace(
                value, **{each.name: self._moved(getattr(value, each.name)) for each in fields(value)}
            )
        return value

    def _place(self, span: Span) -> Span:
        if span.line < FAR:
            return span
        far, near = self._lines[bisect_right(self._lines, (span.line, FAR)) - 1]
        offset = near - far
        return replace(span, line=span.line + offset, end_line=span.end_line + offset)
