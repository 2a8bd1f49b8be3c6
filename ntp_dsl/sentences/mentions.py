"""Which objects, members and numbers the words of a sentence stand for.

A noun phrase is a name ("block 3", "the wine bottle"), or a kind with properties ("the red block", "all
cups"): types, groups of the scene and traits are words for objects.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import combinations
from math import comb, log

from ntp_dsl.language.names.symbol_table import UNITS
from ntp_dsl.language.registry import Registry
from ntp_dsl.semantics.observation import SceneObject
from ntp_dsl.sentences.english import (
    COMMON,
    DETERMINERS,
    EVERY,
    LARGE,
    LINKS,
    NUMBERS,
    ONES,
    SMALL,
    name_words,
    number_of,
    singular,
    singulars,
    stem,
)

CONTAINING = frozenset(
    "of with that which contain contains containing filled full has have having hold holds holding are is "
    "in".split()
)
CONTENTS_END = frozenset("in it them inside".split())
MOST_WAYS = 60  # to choose some of many
LONGEST = 7  # words of a noun phrase
UNLIKELY = log(0.05)  # that a group as a whole is meant by a word for one of its members
UNIT_WORDS = {
    "degree": "deg", "degrees": "deg", "centimetre": "cm", "centimetres": "cm", "centimeter": "cm",
    "centimeters": "cm", "millimetre": "mm", "millimetres": "mm", "millimeter": "mm", "millimeters": "mm",
    "metre": "m", "metres": "m", "meter": "m", "meters": "m", "seconds": "s", "milliseconds": "ms",
    "radian": "rad", "radians": "rad", "newton": "N", "newtons": "N", "n": "N", "kilogram": "kg",
    "kilograms": "kg", "kilos": "kg",
}  # fmt: skip
LINKS_OF_A_SPAN = (["to"], ["through"], ["-"])


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


@dataclass(frozen=True)
class _Known:
    """The words for one object."""

    name: tuple[str, ...]
    kinds: frozenset[str]  # nouns that its number may follow
    heads: frozenset[str]  # nouns for it, traits among them
    properties: frozenset[str]
    number: str


class Vocabulary:
    """The words for the objects of a scene, and for the members and constants of a library."""

    def __init__(
        self,
        registry: Registry,
        objects: Sequence[SceneObject],
        groups: Mapping[str, Sequence[str]] | None = None,
    ) -> None:
        self.types = dict(registry.constants) | {obj.name: obj.type for obj in objects}
        self._sizes = {obj.name: obj.size[0] * obj.size[1] * obj.size[2] for obj in objects}
        traits = {obj.name: dict(obj.traits) for obj in objects}
        self._objects = {
            name: _known(registry, name, kind, traits.get(name, {}), groups)
            for name, kind in self.types.items()
        }
        self._movable = [obj.name for obj in objects if obj.movable]
        members = (member for members in registry.enums.values() for member in members)
        self._members = {tuple(name_words(member)): member for member in members}
        self._remembered: dict[tuple[str, ...], tuple[Mention, ...]] = {}
        self._heads = {word for each in self._objects.values() for word in each.heads}
        self._words = self._heads | {word for each in self._objects.values() for word in each.properties}
        self._words |= {word for each in self._objects.values() for word in each.name}
        self._words |= {word for member in self._members for word in member}

    def knows(self, word: str) -> bool:
        """Return whether a word is one of the library's or the scene's things."""
        return not singulars(word).isdisjoint(self._words) or bool(number_of(word.replace(".", "", 1)))

    @property
    def things(self) -> list[str]:
        """Return the names of all objects and members."""
        return [*self._objects, *self._members.values()]

    def mentions(self, tokens: Sequence[str]) -> list[Mention]:
        """Return the noun phrases of a clause, from left to right; each is as long as can be."""
        key = tuple(tokens)
        if key not in self._remembered:
            self._remembered[key] = tuple(self._found_in(key))
        return [*self._remembered[key]]

    def _found_in(self, tokens: Sequence[str]) -> list[Mention]:
        found: list[Mention] = []
        at = 0
        while at < len(tokens):
            ends = range(min(len(tokens), at + LONGEST), at, -1)
            mention = next((each for end in ends if (each := self._mention(tokens, at, end))), None)
            if mention is None:
                at += 1
                continue
            mention = self._more_numbers(tokens, mention)
            whole = self._with_contents(tokens, found[-1], mention) if found else None
            if whole is not None:
                found[-1] = mention = whole
            else:
                found.append(mention)
            at = mention.end
        if len(found) > 1 and found[0].end == found[1].begin and self._may_be_verb(tokens, found[0]):
            return found[1:]
        return found

    def _with_contents(self, tokens: Sequence[str], first: Mention, of: Mention) -> Mention | None:
        """Return "cups of tea", "every cup that has tea in it" as one noun phrase; None where it is none."""
        between = [*tokens[first.end : of.begin]]
        members = {value for sense in of.senses for value in sense.values if value in self._members.values()}
        is_certain = len(first.senses) == 1 and first.senses[0].values[0] in self.types
        if is_certain and not members and between == ["of"]:
            return replace(first, end=of.end)  # "the drawer of the cabinet"
        if not members or not between or not CONTAINING.issuperset(between):
            return None
        bearers = {value for sense in of.senses for value in sense.values if value not in members}
        of_kind = [*dict.fromkeys(value for sense in first.senses for value in sense.values)]
        found = tuple(value for value in of_kind if value in bearers)
        if not found:
            return None
        end = of.end
        while end < len(tokens) and tokens[end] in CONTENTS_END:
            end += 1
        senses = [*(each for each in of.senses if each.values[0] in members), Sense(found)]
        return Mention(first.begin, end, tuple(senses), first.head, len(found) > 1)

    def _may_be_verb(self, tokens: Sequence[str], first: Mention) -> bool:
        """Return whether a clause begins with a noun that is a verb there: "pad the crate"."""
        is_bare = first.begin == 0 and first.end == 1 and tokens[0] == first.head
        return is_bare and len(first.senses) > 1 and (tokens[0],) not in self._members

    def _mention(self, tokens: Sequence[str], begin: int, end: int) -> Mention | None:
        phrase = list(tokens[begin:end])
        if phrase == ["everything"] and self._movable:
            return Mention(begin, end, (Sense(tuple(self._movable)),), "thing", True)
        if len(phrase) == 1 and phrase[0] in DETERMINERS | EVERY:
            named = [name for name, known in self._objects.items() if known.name == (phrase[0],)]
            goes_on = end < len(tokens) and not singulars(tokens[end]).isdisjoint(self._words)
            return Mention(begin, end, (Sense((named[0],)),), phrase[0]) if named and not goes_on else None
        every = phrase[0] in EVERY
        while phrase and (phrase[0] in DETERMINERS | EVERY or (every and phrase[0] == "of")):
            phrase = phrase[1:]
        if not phrase or phrase[-1] in DETERMINERS | {"of", ",", "and"}:
            return None
        if number := _measured(phrase):
            return Mention(begin, end, (number,))
        if len({*phrase}) < len(phrase) and not number_of(phrase[-1]):
            return None  # "red red" are two
        is_numbered = end < len(tokens) and bool(number_of(tokens[end]))
        if not is_numbered and (counted := self._counted(phrase)):
            return Mention(begin, end, tuple(counted), singular(phrase[-1]), True)
        senses = [*self._exact(phrase)] or [*self._described(phrase, every)]
        if end - begin == 1 and stem(phrase[0]) in COMMON and singular(phrase[0]) == phrase[0]:
            return None  # "seat", "place" and "stack" as verbs
        if not senses:
            return None
        many = every or any(len(each.values) > 1 for each in senses)
        nouns = [word for word in phrase if not number_of(word)]
        is_member = senses[0].values[0] in self._members.values()
        return Mention(begin, end, tuple(senses), singular(nouns[-1]) if nouns else "", many, is_member)

    def _counted(self, phrase: Sequence[str]) -> list[Sense]:
        """Return "two forks": any two of them; nothing where it is no count, or there are too many ways."""
        count, noun = number_of(phrase[0]), phrase[-1]
        if not count or len(phrase) < 2 or number_of(noun):
            return []
        if noun == singular(noun) and phrase[0] != "one":
            return []
        names = [value for sense in self._described(phrase[1:], True) for value in sense.values]
        ways = comb(len(names), int(count))
        if not 0 < ways <= MOST_WAYS or not int(count):
            return []
        return [Sense(each, -log(ways)) for each in combinations(names, int(count))]

    def is_kind(self, word: str) -> bool:
        """Return whether a word is the noun of numbered objects."""
        return any(word in known.kinds and known.number for known in self._objects.values())

    def _exact(self, phrase: Sequence[str]) -> Iterator[Sense]:
        """Yield what is called so."""
        given = tuple((number_of(word) or word) if at else word for at, word in enumerate(phrase))
        for name, known in self._objects.items():
            if known.name == given:
                yield Sense((name,))
        for member, name in self._members.items():
            if len(member) == len(phrase) and all(
                word in singulars(each) for word, each in zip(member, phrase, strict=True)
            ):
                yield Sense((name,))
                bearers = [other for other, known in self._objects.items() if member[-1] in known.properties]
                if len(member) == 1 and bearers:
                    many = phrase[-1] != member[-1] or len(bearers) == 1
                    yield from _one_or_all(bearers, many)

    def _described(self, phrase: Sequence[str], every: bool) -> Iterator[Sense]:
        """Yield the objects of a kind that have all the properties."""
        number = number_of(phrase[-1]) if len(phrase) > 1 else ""
        noun, others = phrase[-2 if number else -1], phrase[: -2 if number else -1]
        if any(stem(word) in COMMON for word in others):
            return  # "place block 6" is no kind of block
        sizes = [word for word in others if word in LARGE | SMALL]
        others = [word for word in others if word not in sizes]
        found = []
        for name, known in self._objects.items():
            heads = known.kinds if number else known.heads
            fits = noun in ONES or not singulars(noun).isdisjoint(heads)
            if not fits or (number and known.number != number):
                continue
            if all(not singulars(word).isdisjoint(known.properties) for word in others):
                found.append(name)
        if noun in ONES and not others and not sizes:
            return
        for word in sizes:
            found = self._extreme(found, word in LARGE)
        if found:
            yield from _one_or_all(found, every or (noun != singular(noun) and not number))

    def _extreme(self, names: Sequence[str], largest: bool) -> list[str]:
        sizes = [self._sizes.get(name, 0.0) for name in names]
        if not sizes:
            return []
        limit = max(sizes) * 0.95 if largest else min(sizes) * 1.05
        return [
            name
            for name, size in zip(names, sizes, strict=True)
            if (size >= limit if largest else size <= limit)
        ]

    def _span(self, tokens: Sequence[str], first: Mention) -> Mention | None:
        """Return "blocks 1 to 3" as one noun phrase; None where it is none."""
        if tokens[first.end - 2] == first.head or tokens[first.end : first.end + 1] not in LINKS_OF_A_SPAN:
            return None
        low = number_of(tokens[first.end - 1])
        high = "".join(number_of(word) for word in tokens[first.end + 1 : first.end + 2])
        if not low or not high or int(high) - int(low) > len(self._objects):
            return None
        each = [self._mention([first.head, str(n)], 0, 2) for n in range(int(low), int(high) + 1)]
        named = tuple(value for one in each if one for value in one.senses[0].values)
        if not all(each) or not named:
            return None
        return replace(first, end=first.end + 2, senses=(Sense(named),), is_many=True)

    def _more_numbers(self, tokens: Sequence[str], first: Mention) -> Mention:
        """Return a mention with the numbers that follow: "blocks 1, 2 and 3"."""
        if first.end - first.begin < 2 or not (number_of(tokens[first.end - 1]) and first.head):
            return first
        if (span := self._span(tokens, first)) is not None:
            return span
        values, at = [*first.senses[0].values], first.end
        while at + 1 < len(tokens) and tokens[at] in LINKS:
            after = at + 2 if [*tokens[at : at + 2]] == [",", "and"] else at + 1
            number = number_of(tokens[after]) if after < len(tokens) else ""
            follows = tokens[after + 1] if after + 1 < len(tokens) else ""
            if not number or self.knows(follows) or follows in UNIT_WORDS or follows in UNITS:
                break
            more = self._mention([first.head, number], 0, 2)
            if more is None:
                break
            values += more.senses[0].values
            at = after + 1
        if at == first.end:
            return first
        return replace(first, end=at, senses=(Sense(tuple(values)),), is_many=True)


def _known(
    registry: Registry,
    name: str,
    kind: str,
    traits: Mapping[str, str | float],
    groups: Mapping[str, Sequence[str]] | None,
) -> _Known:
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
    return _Known(parts, own, frozenset(heads), frozenset(properties), number)


def _one_or_all(names: Sequence[str], many: bool) -> Iterator[Sense]:
    """Yield that all are meant, or any one."""
    if many or len(names) == 1:
        yield Sense(tuple(names))
    else:
        for name in names:
            yield Sense((name,), -log(len(names)))


def _measured(phrase: Sequence[str]) -> Sense | None:
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
