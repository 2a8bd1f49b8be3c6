"""Nonsense words, none twice and none that the language or its standard libraries use."""

from __future__ import annotations

from random import Random

from ntp_dsl.language.parsing.term_builder import RESERVED

CONSONANTS = "b d f g h j k l m n p r s t v z".split()
VOWELS = "a e i o u".split()
ENDINGS = ("", "", "b", "f", "k", "l", "m", "n", "p", "sk", "rt", "x")
TWO_WORDS = 0.15  # of names, joined by an underscore
TAKEN = RESERVED | frozenset(  # that have four letters or more and could be put together by chance
    "goal table python list item cube mesh urdf time mass angle length number force record task use".split()
)


class Names:
    """Makes words from a generator of its own, so that what things are called decides nothing else."""

    def __init__(self, rng: Random) -> None:
        self._rng = rng
        self._used = set(TAKEN)

    def word(self) -> str:
        """Return a new word in small letters."""
        while True:
            word = self._syllables()
            if self._rng.random() < TWO_WORDS:
                word += f"_{self._syllables()}"
            if word not in self._used:
                self._used.add(word)
                return word

    def type(self) -> str:
        """Return a new word with a capital; no other name differs from it by that alone."""
        return "".join(part.capitalize() for part in self.word().split("_"))

    def _syllables(self) -> str:
        pick = self._rng.choice
        return "".join(pick(CONSONANTS) + pick(VOWELS) for _ in range(2)) + pick(ENDINGS)
