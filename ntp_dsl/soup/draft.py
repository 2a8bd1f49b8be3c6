"""A library in the making: its declarations by kind, and the random choices that they come from."""

from __future__ import annotations

from collections.abc import Sequence
from random import Random
from typing import TypeVar

from ntp_dsl.soup.names import Names

Choice = TypeVar("Choice")

LIGHT = ("type", "enum", "record", "predicate")  # declarations without an empty line between them
SECTIONS = (*LIGHT, "api", "program", "task")


class Draft:
    """Collects declarations; later ones may name earlier ones, and programs also call later ones."""

    def __init__(self, rng: Random, names: Names) -> None:
        self.rng, self.names = rng, names
        self._sections: dict[str, list[str]] = {name: [] for name in SECTIONS}

    # Choices ------------------------------------------------------------------------------------

    def chance(self, share: float) -> bool:
        return self.rng.random() < share

    def pick(self, choices: Sequence[Choice]) -> Choice:
        return choices[int(self.rng.random() * len(choices))]

    def between(self, low: int, high: int) -> int:
        """Return a whole number of a range; both ends are possible."""
        return low + int(self.rng.random() * (high - low + 1))

    def shuffled(self, items: Sequence[Choice]) -> list[Choice]:
        keyed = sorted((self.rng.random(), index) for index in range(len(items)))
        return [items[index] for _, index in keyed]

    def size(self, low: float, high: float) -> str:
        """Return a length of a range [cm], in half centimetres, as text."""
        return f"{self.between(round(2 * low), round(2 * high)) / 2:g} cm"

    # Declarations -------------------------------------------------------------------------------

    def declare(self, text: str) -> None:
        """Add a declaration to those of its kind, which is its first word."""
        self._sections[text.split()[0]].append(text)

    def type(self, parent: str) -> str:
        name = self.names.type()
        self.declare(f"type {name} is {parent}")
        return name

    def predicate(self, parameters: str, ending: str) -> str:
        """Declare a predicate; `ending` is its body, its provider or its result."""
        name = self.names.word()
        self.declare(f"predicate {name}({parameters}){ending}")
        return name

    def program(
        self,
        parameters: str,
        requires: Sequence[str],
        achieves: str,
        body: Sequence[str],
        name: str | None = None,
    ) -> str:
        """Declare a program, and return its name."""
        name = name or self.names.word()
        clauses = [f"requires {' and '.join(requires)}"] if requires else []
        rows = [f"program {name}({parameters}):", *clauses, f"achieves {achieves}", *body]
        self.declare("\n    ".join(rows))
        return name

    def text(self, name: str) -> str:
        """Return the whole library."""
        sections = [("\n" if kind in LIGHT else "\n\n").join(parts) for kind, parts in self._sections.items()]
        return "\n\n".join([f"library {name}", "use containers", *filter(None, sections)]) + "\n"


def given(*things: str) -> list[str]:
    """Return what every program requires of the objects that it is about, since nothing provides it."""
    return [f"{fact}({thing})" for thing in things for fact in ("present", "reachable")]
