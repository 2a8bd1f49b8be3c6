"""A clause: its noun phrases, what each of them is in it, and its verbs."""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import pairwise

from ntp_dsl.sentences.english import GOALS, Role
from ntp_dsl.sentences.senses import Mention, Sense

Part = tuple[Role, Mention]


@dataclass(frozen=True)
class Clause:
    """One way to take a clause apart."""

    parts: tuple[Part, ...]
    verbs: frozenset[str]  # stems of the words that are neither noun phrases nor of grammar alone
    mentions: tuple[Mention, ...] = ()  # as they were found, from left to right
    weight: float = 0.0  # logarithm of how probable this way is beside the others
    listed: frozenset[tuple[Mention, Mention]] = frozenset()  # of which one follows the other in a list
    is_firm: bool = False  # it says how things are related in a way that types cannot tell


def without_source(clause: Clause) -> Clause | None:
    """Return "from the table to the tray" without where it comes from; None for what says no such thing."""
    roles = [role for role, _ in clause.parts]
    if Role.FROM not in roles or not GOALS.intersection(roles):
        return None
    parts = tuple(part for part in clause.parts if part[0] is not Role.FROM)
    return replace(clause, parts=parts, is_firm=False)


def with_each(clause: Clause, many: Mention) -> Clause:
    """Return a clause in which what is named together is several noun phrases: "across pillars 2 and 3"."""
    [sense] = many.senses
    each = [
        replace(many, begin=many.begin + at, senses=(replace(sense, values=(value,)),), is_many=False)
        for at, value in enumerate(sense.values)
    ]
    parts = [(role, one) for role, part in clause.parts for one in (each if part is many else [part])]
    mentions = [one for part in clause.mentions for one in (each if part is many else [part])]
    return replace(
        clause, parts=tuple(parts), mentions=tuple(mentions), listed=clause.listed | {*pairwise(each)}
    )


def merged(clause: Clause) -> Clause:
    """Return a clause whose listed themes are one noun phrase, of which all are meant."""
    themes = [each for role, each in clause.parts if role is Role.THEME]
    if len(themes) < 2 or any(each.senses[0].weight for each in themes) or respective(clause):
        return clause
    count = min(len(each.senses) for each in themes)
    listed = (tuple(value for each in themes for value in each.senses[k].values) for k in range(count))
    whole = replace(themes[0], senses=tuple(Sense(values) for values in listed), is_many=True)
    rest = [(role, each) for role, each in clause.parts if role is not Role.THEME]
    return replace(clause, parts=((Role.THEME, whole), *rest))


def respective(clause: Clause) -> list[Clause]:
    """Return a clause for each pair, where as many things as places are listed: "a and b on c and d"."""
    themes = [each for role, each in clause.parts if role is Role.THEME]
    others = [(role, each) for role, each in clause.parts if role is not Role.THEME]
    if len(themes) != len(others) or len(themes) < 2 or len({role for role, _ in others}) > 1:
        return []
    return [
        replace(clause, parts=((Role.THEME, theme), other))
        for theme, other in zip(themes, others, strict=True)
    ]
