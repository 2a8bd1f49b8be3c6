"""Noun phrases, and what they may stand for: objects, members, or numbers with their units."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from math import log

from ntp_dsl.language.names.symbol_table import UNITS
from ntp_dsl.sentences.english import NUMBERS, number_of

UNIT_WORDS = {
    "degree": "deg", "degrees": "deg", "centimetre": "cm", "centimetres": "cm", "centimeter": "cm",
    "centimeters": "cm", "millimetre": "mm", "millimetres": "mm", "millimeter": "mm", "millimeters": "mm",
    "metre": "m", "metres": "m", "meter": "m", "meters": "m", "seconds": "s", "milliseconds": "ms",
    "radian": "rad", "radians": "rad", "newton": "N", "newtons": "N", "n": "N", "kilogram": "kg",
    "kilograms": "kg", "kilos": "kg",
}  # fmt: skip


@dataclass(frozen=True)
class Sense:
    """What a noun phrase may stand for: objects (all of them are meant), a member, or a number."""

    values: tuple[str | float, ...]
    weight: float = 0.0  # logarithm of a probability
    measures: str = ""  # what the unit of a number measures

    @property
    def is_number(self) -> bool:
        return isinstance(self.values[0], float)


@dataclass(frozen=True)
class Mention:
    """A noun phrase: tokens [begin, end), and what it may stand for."""

    begin: int
    end: int
    senses: tuple[Sense, ...]
    head: str = ""  # its noun, for "the other one"
    is_many: bool = False
    is_member: bool = False  # of an enumeration
    label: tuple[str, ...] = ()  # which parameter it is, where that is said: "ground" of "ground white"


def one_or_all(names: Sequence[str], many: bool) -> Iterator[Sense]:
    """Yield that all are meant, or any one."""
    if many or len(names) == 1:
        yield Sense(tuple(names))
    else:
        for name in names:
            yield Sense((name,), -log(len(names)))


def measured(phrase: Sequence[str]) -> Sense | None:
    """Return a number with its unit, or one without."""
    sign, rest = (-1.0, phrase[1:]) if phrase[0] == "-" else (1.0, phrase)
    if not 1 <= len(rest) <= 2 or not number_of(rest[0].replace(".", "", 1)):
        return None
    if len(rest) == 1:
        return None if rest[0] in NUMBERS else Sense((sign * float(rest[0]),), measures="number")
    unit = UNIT_WORDS.get(rest[1], rest[1])
    if unit not in UNITS:
        return None
    measures, scale = UNITS[unit]
    return Sense((sign * float(NUMBERS.get(rest[0], rest[0])) * scale,), measures=measures)
