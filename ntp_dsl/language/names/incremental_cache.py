"""Which declarations were found sound, and what that rests on, so that an edit costs what it concerns."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

from ntp_dsl.language.diagnostics.diagnostics import Diagnostic
from ntp_dsl.language.names.references import mentions
from ntp_dsl.language.names.symbol_table import Watched
from ntp_dsl.language.parsing.partial_library import Key
from ntp_dsl.language.syntax.nodes import Declaration


@dataclass(frozen=True)
class _Verdict:
    """That nothing is wrong with a declaration, as long as every look-up yields what it did."""

    declaration: Declaration  # kept, so that its identity is
    grounds: object
    answers: tuple[tuple[int, object, object], ...]  # which dictionary, the key, what it yielded

    def holds(self, dictionaries: Sequence[Watched[Any, Any]], grounds: object) -> bool:
        for index, key, answer in self.answers:
            # Nearly all is the very same, which is told without asking by our own way.
            if dict.get(dictionaries[index], key) is not answer:
                if not _same(dictionaries[index].answer(key), answer):
                    return False
        return self.grounds == grounds


class IncrementalCache:
    """The verdicts of the last two runs. Only what was found sound is kept in mind."""

    def __init__(self) -> None:
        self._before: dict[tuple[int, object], _Verdict] = {}
        self._now: dict[tuple[int, object], _Verdict] = {}
        self._mentions: dict[int, tuple[Declaration, frozenset[Key]]] = {}

    def begin(self) -> None:
        """Another run begins: what the last one did not come to is forgotten."""
        self._before, self._now = self._now, {}
        kept = {id(verdict.declaration) for verdict in self._before.values()}
        self._mentions = {each: found for each, found in self._mentions.items() if each in kept}

    def recall(
        self,
        declaration: Declaration,
        matter: object,
        dictionaries: Sequence[Watched[Any, Any]],
        grounds: object,
        check: Iterator[Diagnostic],
    ) -> Sequence[Diagnostic]:
        """Return what the check yields: known to be nothing, or found by running it.

        Args:
            matter: what is checked about the declaration.
            dictionaries: all in which the check looks anything up.
            grounds: all else that it rests on.
            check: one that has not begun.
        """
        place = id(declaration), matter
        verdict = self._before.get(place)
        if verdict is not None and verdict.holds(dictionaries, grounds):
            self._now[place] = verdict
            return ()
        for dictionary in dictionaries:
            dictionary.asked.clear()
        found = [*check]
        if not found:
            answers = [
                (index, key, dictionary.answer(key))
                for index, dictionary in enumerate(dictionaries)
                for key in dictionary.asked
            ]
            self._now[place] = _Verdict(declaration, grounds, tuple(answers))
        return found

    def mentions(self, declaration: Declaration) -> frozenset[Key]:
        """What a declaration speaks of."""
        known = self._mentions.get(id(declaration))
        if known is None:
            known = self._mentions[id(declaration)] = declaration, mentions(declaration)
        return known[1]


def _same(one: object, other: object) -> bool:
    """The very same, or what means the same: where things stand in the text does not count."""
    return one is other or one == other
