"""The words for one object: its name, its kinds, its traits, and the groups of the scene that it is in."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from ntp_dsl.language.registry import Registry
from ntp_dsl.sentences.english import name_words, number_of, singular


@dataclass(frozen=True)
class Known:
    """The words for one object."""

    name: tuple[str, ...]
    kinds: frozenset[str]  # nouns that its number may follow
    heads: frozenset[str]  # nouns for it, traits among them
    properties: frozenset[str]
    number: str


def known_words(
    registry: Registry,
    name: str,
    kind: str,
    traits: Mapping[str, str | float],
    groups: Mapping[str, Sequence[str]] | None,
) -> Known:
    parts = tuple(name_words(name))
    nouns = [word for word in parts if not number_of(word)]
    kinds = [name_words(each) for each in registry.ancestors(kind)]
    heads = {*nouns[-1:], *(each[-1] for each in kinds if each)}
    own = frozenset(heads)
    properties = {*nouns, *(word for each in kinds for word in each)}
    for value in traits.values():
        if isinstance(value, str):
            properties |= {*name_words(value)}
            heads |= {*name_words(value)[-1:]}
    for group, names in (groups or {}).items():
        if name in names and (of := name_words(group)):
            heads.add(singular(of[-1]))
            properties |= {*of, singular(of[-1])}
    number = number_of(parts[-1]) if parts else ""
    return Known(parts, own, frozenset(heads), frozenset(properties), number)
