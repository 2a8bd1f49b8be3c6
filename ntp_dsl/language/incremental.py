"""Checks libraries again and again while they are edited, and does again only what an edit concerns.

Each declaration's text is read once, as if it stood on lines of its own far below any file; whatever is said
of it is moved to where it stands now.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

from ntp_dsl.language.checks.check_library import examine
from ntp_dsl.language.diagnostics.diagnostics import Diagnostic, Edit, SourceError
from ntp_dsl.language.loader import Reading, Report, shelf
from ntp_dsl.language.names.incremental_cache import Memory
from ntp_dsl.language.parsing.blocks import Piece
from ntp_dsl.language.parsing.error_recovery import Parsed
from ntp_dsl.language.parsing.parser import parse_piece, read
from ntp_dsl.language.parsing.partial_library import Draft
from ntp_dsl.language.syntax.nodes import Span

FAR = 1_000_000_000  # the first line that belongs to no file

Place = tuple[Path | None, str, int]  # a text, and how many like it stand above it in the file


class Session:
    """Keeps what was read and found out, from one check to the next."""

    def __init__(self) -> None:
        self._memory = Memory()
        self._known: dict[Place, Parsed] = {}
        self._free = FAR

    def diagnose(self, path: Path, texts: Mapping[Path, str] | None = None) -> Report:
        """What `diagnose` of the loader says.

        Args:
            texts: of files as they are edited, in place of what is on the disk.
        """
        self._memory.begin()
        visit = _Visit(self)
        reading = Reading(path, texts or {}, visit.read)
        found = examine(reading.units(), lambda: shelf(path), self._memory)
        self._known = visit.seen
        said = [visit.moved(each) for each in [*reading.mistakes, *found]]
        return Report(SourceError(said).diagnostics, reading.sources)

    def parsed(self, place: Place, piece: Piece) -> Parsed:
        """The piece as it was read before, or reads now."""
        if place not in self._known:
            self._known[place] = parse_piece(replace(piece, line=self._free))
            self._free += piece.text.count("\n") + 1
        return self._known[place]


class _Visit:
    """One check: which pieces were come to, and where they stand."""

    def __init__(self, session: Session) -> None:
        self._session = session
        self.seen: dict[Place, Parsed] = {}
        self._lines: list[tuple[int, int]] = []  # the first line far below, and the one in the file

    def read(self, text: str, path: Path | None) -> Draft:
        """As the parser reads a draft, with what is known already."""
        counts: dict[str, int] = {}

        def read_piece(piece: Piece) -> Parsed:
            if piece.mistakes:
                return parse_piece(piece)
            counts[piece.text] = counts.get(piece.text, 0) + 1
            place = path, piece.text, counts[piece.text]
            parsed = self.seen[place] = self._session.parsed(place, piece)
            self._lines.append((parsed.piece.line, piece.line))
            return parsed

        return read(text, path, read_piece)

    def moved(self, diagnostic: Diagnostic) -> Diagnostic:
        """The diagnostic with all its places as they are in the files."""
        self._lines.sort()
        notes = tuple(replace(note, span=self._place(note.span)) for note in diagnostic.notes)
        fix = diagnostic.fix
        if fix is not None:
            also = tuple(Edit(self._place(each.span), each.replacement) for each in fix.also)
            fix = replace(fix, span=self._place(fix.span), also=also)
        return replace(diagnostic, span=self._place(diagnostic.span), notes=notes, fix=fix)

    def _place(self, span: Span) -> Span:
        if span.line < FAR:
            return span
        far, near = self._lines[bisect_right(self._lines, (span.line, FAR)) - 1]
        below = near - far
        return replace(span, line=span.line + below, end_line=span.end_line + below)
