"""The words of a library for what a program's lists consist of: their fields, and what these may be."""

from __future__ import annotations

from dataclasses import dataclass

from ntp_dsl.language.registry import Program, Registry
from ntp_dsl.sentences.english import OPPOSITES, RELATIONS, name_words, number_of


@dataclass(frozen=True)
class OwnWords:
    """What a program's lists consist of, as far as noun phrases hang on it."""

    labels: tuple[tuple[str, ...], ...] = ()  # names of fields and records, and of members' kinds
    sides: tuple[str, ...] = ()  # names of fields that are relations: "the near chair"
    offsets: tuple[str, ...] = ()  # and are numbers: "5 cm ahead"
    types: frozenset[str] = frozenset()  # of fields: enumerations, kinds of objects, numbers
    takes_counts: bool = False  # a field is a number without a unit, or a member named as one


def own_words(registry: Registry, program: Program) -> OwnWords:
    """Return the words for what a program's lists consist of."""
    found: dict[tuple[str, ...], None] = {}
    types: set[str] = set()
    sides: list[str] = []
    offsets: list[str] = []
    for parameter in program.parameters:
        if not parameter.is_list:
            continue
        fields = registry.records.get(parameter.type, ())
        for each in fields:
            found[words := tuple(name_words(each.name))] = None
            if registry.is_number(each.type) and len(words) == 1:
                offsets += [word for word in words if word in RELATIONS | OPPOSITES.keys()]
            elif len(words) == 1:
                sides += [word for word in words if word in RELATIONS | OPPOSITES.keys()]
            if each.type in registry.enums:
                found[tuple(name_words(each.type))] = None
        if fields:
            found[tuple(name_words(parameter.type))] = None
        types |= {each.type for each in fields} or {parameter.type}
    labels = (each for each in found if not RELATIONS.issuperset(each))
    members = [member for each in types for member in registry.enums.get(each, ())]
    counts = any(number_of(each) for each in members) or "number" in types
    return OwnWords(
        tuple(sorted(labels, key=len, reverse=True)), tuple(sides), tuple(offsets), frozenset(types), counts
    )
