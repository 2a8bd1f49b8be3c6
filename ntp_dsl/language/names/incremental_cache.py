"""Which declarations are known to be sound, and on what look-ups that rests, so that an edit is cheap."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

from ntp_dsl.language.diagnostics.diagnostics import Diagnostic
from ntp_dsl.language.names.references import references
from ntp_dsl.language.names.symbol_table import TrackedDict
from ntp_dsl.language.parsing.partial_library import Key
from ntp_dsl.language.syntax.nodes import Declaration


@dataclass(frozen=True)
class _SoundResult:
    """Nothing is wrong with a declaration, as long as every look-up yields what it did."""

    declaration: Declaration  # kept alive, so that its identity is not reused
    basis: object
    lookups: tuple[tuple[int, object, object], ...]  # which dictionary, the key, what it yielded

    def holds(self, dictionaries: Sequence[TrackedDict[Any, Any]], basis: object) -> bool:
        for index, key, answer in self.lookups:
            # Nearly every answer is the same object, and `dict.get` is quicker than `peek`.
            if dict.get(dictionaries[index], key) is not answer:
                if not _same(dictionaries[index].peek(key), answer):
                    return False
        return self.basis == basis


class IncrementalCache:
    """The sound results of the last two runs."""

    def __init__(self) -> None:
        self._previous: dict[tuple[int, object], _SoundResult] = {}
        self._current: dict[tuple[int, object], _SoundResult] = {}
        self._references: dict[int, tuple[Declaration, frozenset[Key]]] = {}

    def begin(self) -> None:
        """Begin another run; forget what the last one did not come to."""
        self._previous, self._current = self._current, {}
        kept = {id(result.declaration) for result in self._previous.values()}
        self._references = {each: found for each, found in self._references.items() if each in kept}

    def reuse_or_run(
        self,
        declaration: Declaration,
        question: object,
        dictionaries: Sequence[TrackedDict[Any, Any]],
        basis: object,
        check: Iterator[Diagnostic],
    ) -> Sequence[Diagnostic]:
        """Return what the check yields: known to be nothing, or found by running it.

        Args:
            question: which check of the declaration it is.
            dictionaries: all in which the check looks anything up.
            basis: all else that it rests on.
            check: one that has not begun.
        """
        place = id(declaration), question
        result = self._previous.get(place)
        if result is not None and result.holds(dictionaries, basis):
            self._current[place] = result
            return ()
        for dictionary in dictionaries:
            dictionary.looked_up.clear()
        found = [*check]
        if not found:
            lookups = [
                (index, key, dictionary.peek(key))
                for index, dictionary in enumerate(dictionaries)
                for key in dictionary.looked_up
            ]
            self._current[place] = _SoundResult(declaration, basis, tuple(lookups))
        return found

    def references(self, declaration: Declaration) -> frozenset[Key]:
        """Return the names that a declaration refers to."""
        known = self._references.get(id(declaration))
        if known is None:
            known = self._references[id(declaration)] = declaration, references(declaration)
        return known[1]


def _same(one: object, other: object) -> bool:
    """Return whether both mean the same: places in the text do not count."""
    return one is other or one == other
