"""A library as far as its text could be read, from what was parsed of the text's blocks."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import zip_longest
from pathlib import Path

from ntp_dsl.language.diagnostics.diagnostics import Diagnostic, Fix
from ntp_dsl.language.parsing import blocks
from ntp_dsl.language.parsing.parsed import Parsed
from ntp_dsl.language.parsing.shared_scenes import with_shared_scenes
from ntp_dsl.language.parsing.tree_builder import Header
from ntp_dsl.language.syntax.nodes import Declaration, Library, Span, Use

Key = tuple[str, str]  # a namespace and a name in it
UNNAMED = "NAME"


@dataclass(frozen=True)
class PartialLibrary:
    """A library as far as its text could be read: enough to look for more mistakes, but no proof of anything.

    Of `incomplete` declarations the signature is known, but lines are missing; of `unreadable` ones only the
    name is. The defaults are for a text without mistakes.
    """

    library: Library
    diagnostics: tuple[Diagnostic, ...] = ()
    incomplete: frozenset[Key] = frozenset()
    unreadable: frozenset[Key] = frozenset()
    guessed: frozenset[int] = frozenset()  # lines that are read as they were probably meant
    lacks_uses: bool = False  # a `use` could not be read: any name may come from there


def assemble(found: Sequence[Parsed], path: Path | None) -> PartialLibrary:
    """Assemble what was parsed of a text's blocks, in their order."""
    items = [parsed.item for parsed in found]
    headers = [item for item in items if isinstance(item, Header)]
    stem = path.stem if path and path.stem.isidentifier() else UNNAMED
    declarations, unshared = with_shared_scenes([item for item in items if isinstance(item, Declaration)])
    library = Library(
        headers[0].name if headers else stem,
        tuple(item for item in items if isinstance(item, Use)),
        declarations,
        headers[0].docstring if headers else "",
        path,
    )
    diagnostics = [each for parsed in found for each in parsed.diagnostics]
    return PartialLibrary(
        library,
        (*diagnostics, *_check_header(headers, found, stem, path), *unshared),
        frozenset(_incomplete(found)),
        frozenset(key for parsed in found for key in parsed.unreadable),
        frozenset(line for parsed in found for line in parsed.guessed),
        any(parsed.block.keyword in {"library", "use"} and not parsed.is_whole for parsed in found),
    )


def _incomplete(found: Sequence[Parsed]) -> Iterator[Key]:
    after = [parsed.block.keyword for parsed in found[1:]]
    for parsed, following in zip_longest(found, after, fillvalue=None):
        assert parsed is not None
        # A line at the margin that begins no declaration may belong to the one above it.
        is_cut = following is not None and following not in blocks.KEYWORDS
        if isinstance(parsed.item, Declaration) and (is_cut or not parsed.is_whole):
            yield blocks.NAMESPACES[parsed.block.keyword], parsed.item.name


def _check_header(
    headers: Sequence[Header], found: Sequence[Parsed], stem: str, path: Path | None
) -> Iterator[Diagnostic]:
    top = Span(path, 1, 1, 1, 1)
    if not headers and not any(parsed.item is None for parsed in found):
        help = f"write 'library {stem}' above everything else"
        fix = Fix(top, f"library {stem}\n\n", certain=stem != UNNAMED)
        message = "the text does not name its library"
        yield Diagnostic("E005", message, top, help=help, fix=fix)
    for header in headers[1:]:
        yield Diagnostic("E005", "a text is one library; this is another header", header.span)
    if headers and found[0].item is not headers[0] and found[0].item is not None:
        yield Diagnostic("E005", "'library' comes before everything else", headers[0].span)
