"""What could be read of a block of a text."""

from __future__ import annotations

from dataclasses import dataclass

from ntp_dsl.language.diagnostics.diagnostics import Diagnostic
from ntp_dsl.language.parsing.blocks import Block
from ntp_dsl.language.parsing.tree_builder import Item


@dataclass(frozen=True)
class Parsed:
    """What could be read of a block. Where `is_whole` is false, some of its lines are missing."""

    block: Block  # repaired
    item: Item | None
    diagnostics: tuple[Diagnostic, ...] = ()
    is_whole: bool = True
    unreadable: frozenset[tuple[str, str]] = frozenset()  # what its words seem to declare
    guessed: frozenset[int] = frozenset()  # lines that are read as they were probably meant
