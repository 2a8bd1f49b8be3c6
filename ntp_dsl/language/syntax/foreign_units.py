"""Units that people write and the language does not have, with their exact size in one that it has."""

from __future__ import annotations

from collections.abc import Mapping
from decimal import Decimal

from ntp_dsl.language.syntax.nodes import Number

SPELLINGS: Mapping[str, tuple[str, ...]] = {  # of the language's units, without a plural's s
    "m": ("meter", "metre"),
    "cm": ("centimeter", "centimetre"),
    "mm": ("millimeter", "millimetre"),
    "rad": ("radian",),
    "deg": ("degree", "°"),
    "s": ("sec", "second"),
    "ms": ("msec", "millisecond"),
    "N": ("newton",),
    "kg": ("kilogram", "kilogramme", "kilo"),
}
SIZES: Mapping[str, tuple[str, str]] = {  # unit -> its size
    "km": ("1000", "m"), "dm": ("0.1", "m"), "um": ("0.001", "mm"), "µm": ("0.001", "mm"),
    "μm": ("0.001", "mm"), "nm": ("0.000001", "mm"), "in": ("2.54", "cm"), "inch": ("2.54", "cm"),
    "inches": ("2.54", "cm"), "ft": ("0.3048", "m"), "foot": ("0.3048", "m"), "feet": ("0.3048", "m"),
    "yd": ("0.9144", "m"), "yard": ("0.9144", "m"),
    "kilometer": ("1000", "m"), "kilometre": ("1000", "m"), "decimeter": ("0.1", "m"),
    "decimetre": ("0.1", "m"), "micrometer": ("0.001", "mm"), "micrometre": ("0.001", "mm"),
    "micron": ("0.001", "mm"),
    "g": ("0.001", "kg"), "gram": ("0.001", "kg"), "gramme": ("0.001", "kg"), "mg": ("0.000001", "kg"),
    "milligram": ("0.000001", "kg"), "t": ("1000", "kg"), "tonne": ("1000", "kg"),
    "lb": ("0.45359237", "kg"), "pound": ("0.45359237", "kg"), "oz": ("0.028349523125", "kg"),
    "min": ("60", "s"), "minute": ("60", "s"), "h": ("3600", "s"), "hr": ("3600", "s"), "hour": ("3600", "s"),
    "us": ("0.001", "ms"), "µs": ("0.001", "ms"), "μs": ("0.001", "ms"), "ns": ("0.000001", "ms"),
    "microsecond": ("0.001", "ms"),
    "gon": ("0.9", "deg"), "mrad": ("0.001", "rad"), "turn": ("360", "deg"),
    "revolution": ("360", "deg"),
    "kN": ("1000", "N"), "mN": ("0.001", "N"), "kilonewton": ("1000", "N"),
}  # fmt: skip
AMBIGUOUS: Mapping[str, str] = {  # what each may mean
    "grad": "a degree or a gon", "grads": "a degree or a gon", "Grad": "a degree or a gon",
}  # fmt: skip
PRODUCTS: Mapping[str, str] = {  # what no number of the language measures
    "Nm": "a torque", "Nmm": "a torque", "Pa": "a pressure", "bar": "a pressure", "Hz": "a frequency",
    "V": "a voltage", "A": "a current", "W": "a power", "J": "an energy", "C": "a temperature",
    "K": "a temperature", "mps": "a speed", "rpm": "a speed", "l": "a volume", "ml": "a volume",
    "L": "a volume",
}  # fmt: skip


def in_our_units(value: float, unit: str) -> Number | None:
    """Return exactly the same quantity in a unit of the language, if the unit is known."""
    word = unit.lower().removesuffix("s")
    own = next((each for each, words in SPELLINGS.items() if word in words), None)
    if own is None and len(word) > 1 and unit not in SIZES:
        own = next((each for each in SPELLINGS if word == each.lower() and len(each) > 1), None)
    if own is not None:
        return Number(value, own)
    known = [unit, *(each for each in (unit.lower(), word) if len(each) > 2)]
    size, own = next((SIZES[each] for each in known if each in SIZES), ("", ""))
    return Number(float(Decimal(repr(value)) * Decimal(size)), own) if size else None
