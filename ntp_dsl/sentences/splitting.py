"""A sentence falls into clauses, each of which says one thing."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Sequence
from itertools import groupby

from ntp_dsl.sentences.english import (
    ATTENTION,
    BEARING,
    COMMON,
    COVERING,
    DETERMINERS,
    GIVING,
    GOALS,
    LINKS,
    OPENINGS,
    ORDINALS,
    PREPOSITIONS,
    PRONOUNS,
    TOWERS,
    Role,
    stem,
)
from ntp_dsl.sentences.senses import Mention

STOPS = frozenset(".;!")


def split(tokens: Sequence[str], mentions: Callable[[Sequence[str]], list[Mention]]) -> Iterator[list[str]]:
    """Yield the clauses of a sentence: at stops, at "then", and where both sides say something whole.

    A clause without a verb has that of the one before: "top a tray with a cup, and a plate with a fork".
    """
    verb = ""
    for clause in _cut(tokens, mentions):
        first = next((word for word in clause if word not in OPENINGS | LINKS), "")
        is_verb = stem(first) in COVERING | GIVING
        named = mentions(clause)
        inside = {at for each in named for at in range(each.begin, each.end)}
        has_verb = any(stem(word) in BEARING | COMMON for at, word in enumerate(clause) if at not in inside)
        yield [verb, *clause] if verb and not is_verb and not has_verb and 0 in inside else clause
        verb = first if is_verb else verb


def _cut(tokens: Sequence[str], mentions: Callable[[Sequence[str]], list[Mention]]) -> Iterator[list[str]]:
    start = 0
    if upwards(tokens) is not None:
        yield [each for each in tokens if each not in STOPS]
        return
    if is_a_tower(tokens):
        for part in _at_stops(tokens):
            yield from ([part] if is_a_tower(part) else _cut(part, mentions))
        return
    for at, token in enumerate(tokens):
        if token in STOPS or (token == "then" and at > start):
            yield from _nonempty(tokens[start:at])
            start = at + 1
        elif token == "?" and not ATTENTION.isdisjoint(map(stem, tokens[start:at])):
            yield from _nonempty(tokens[start:at])
            start = at + 1
        elif token in LINKS and tokens[at + 1 : at + 2] == ["which"]:
            yield from _nonempty(tokens[start:at])
            start = at + 1
        elif token in LINKS and tokens[at - 1] == "of":
            continue  # "5 cm ahead of and 3 cm to the left of the pole"
        elif token in LINKS and _is_whole(tokens[start:at], mentions):
            ends = (n for n in range(at + 1, len(tokens)) if tokens[n] in STOPS or tokens[n] == "then")
            rest = tokens[at + 1 : next(ends, len(tokens))]
            links = (n for n, word in enumerate(rest) if word in LINKS and n)
            nearest = [*(rest[:n] for n in links), rest]
            takes = _takes_away(tokens[start:at])
            if any(
                _is_whole(part, mentions) or (not takes and _brings_it(part, mentions)) for part in nearest
            ):
                yield from _nonempty(tokens[start:at])
                start = at + 1
    yield from _nonempty(tokens[start:])


def _at_stops(tokens: Sequence[str]) -> Iterator[list[str]]:
    """Yield what stands between stops."""
    for is_stop, part in groupby(tokens, STOPS.__contains__):
        if not is_stop:
            yield [*part]


def _nonempty(tokens: Sequence[str]) -> Iterator[list[str]]:
    found = [each for each in tokens if each != "?"]
    while found and found[0] in LINKS:
        found = found[1:]
    while found and found[-1] in LINKS:
        found = found[:-1]
    if found:
        yield found


def _is_whole(tokens: Sequence[str], mentions: Callable[[Sequence[str]], list[Mention]]) -> bool:
    """Return whether two noun phrases are related by something: they are not just listed."""
    found = mentions(tokens)
    pairs = zip(found, found[1:], strict=False)
    if any(not is_link(tokens[a.end : b.begin]) for a, b in pairs):
        return True
    if len(found) == 1 and not {"other", *ORDINALS}.isdisjoint(tokens[: found[0].begin]):
        return True  # "the other one for the cup"
    if len(found) == 1 and ("there" in tokens[found[0].end :] or tokens[:1] == ["so"]):
        return True  # "the cups go there too", "so does the cup"
    spoken_of = [
        at for at, word in enumerate(tokens) if at and word in PRONOUNS and (tokens[at - 1],) in PREPOSITIONS
    ]
    if len(found) != 1:
        return False
    goes = {at for at, word in enumerate(tokens) if stem(word) in COMMON}
    return any(at >= found[0].end or at + 1 in goes for at in spoken_of)  # "the cup on it", "on it goes …"


def _takes_away(tokens: Sequence[str]) -> bool:
    """Return whether it is only said where something comes from: "take the cup out of the box"."""
    roles = {PREPOSITIONS.get(tuple(tokens[at : at + size])) for size in (1, 2) for at in range(len(tokens))}
    return Role.FROM in roles and roles.isdisjoint(GOALS - {Role.FROM})


def _brings_it(tokens: Sequence[str], mentions: Callable[[Sequence[str]], list[Mention]]) -> bool:
    """Return whether what was spoken of is brought to a place: "deliver it to the desk"."""
    found = mentions(tokens)
    if len(found) != 1:
        return False
    place = found[0]
    objects = [at for at, word in enumerate(tokens[: place.begin]) if at and word in PRONOUNS - DETERMINERS]
    return any(
        (tokens[at - 1],) not in PREPOSITIONS and (tokens[at + 1],) in PREPOSITIONS and at + 2 == place.begin
        for at in objects
    )


def upwards(tokens: Sequence[str]) -> bool | None:
    """Return whether things are told from the bottom up, or from the top down; None where neither is said."""
    text = f" {' '.join(word for word in tokens if word not in DETERMINERS)} "
    if re.search(r" from (bottom|ground) (up|to top)| going up | bottom to top ", text):
        return True
    return False if re.search(r" from top (down|to bottom)| going down | top to bottom ", text) else None


def is_a_tower(tokens: Sequence[str]) -> bool:
    """Return whether it is told what stands at the bottom of a tower, and what at its top."""
    levels = {level_after(tokens, at) for at in range(len(tokens))}
    return not TOWERS.isdisjoint(map(stem, tokens)) and {0, 2} <= levels


def level_after(tokens: Sequence[str], at: int) -> int | None:
    """Return where in a tower what is named before a word stands: 0 bottom, 1 middle, 2 top."""
    told = [word for word in tokens[at : at + 3] if word != "the"][:2]
    place = told[1] if told[:1] in (["at"], ["on"], ["in"]) and len(told) > 1 else ""
    return {"bottom": 0, "middle": 1, "top": 2}.get(place)


def is_link(between: Sequence[str]) -> bool:
    """Return whether noun phrases with these words between them are listed: "the cup, and the plate"."""
    return bool(between) and LINKS.issuperset(between)
