"""Which objects, members and numbers the words of a sentence stand for.

A noun phrase is a name ("block 3", "the wine bottle"), or a kind with properties ("the red block", "all
cups"): types, groups of the scene and traits are words for objects.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import combinations
from math import comb, log

from ntp_dsl.language.names.symbol_table import UNITS
from ntp_dsl.language.registry import Registry
from ntp_dsl.semantics.observation import SceneObject
from ntp_dsl.sentences.english import (
    BEARING,
    COMMON,
    COVERING,
    DETERMINERS,
    EVERY,
    GIVING,
    LARGE,
    LINKS,
    NUMBERS,
    ONES,
    OPPOSITES,
    SMALL,
    name_words,
    number_of,
    singular,
    singulars,
    stem,
)
from ntp_dsl.sentences.object_words import known_words
from ntp_dsl.sentences.own_words import OwnWords
from ntp_dsl.sentences.senses import UNIT_WORDS, Mention, Sense, measured, one_or_all

NONE = OwnWords()
VERBS = BEARING | COVERING | GIVING | COMMON
CONTAINING = frozenset(
    "of with that which contain contains containing filled full has have having hold holds holding are is "
    "in".split()
)
CONTENTS_END = frozenset("in it them inside".split())
MOST_WAYS = 60  # to choose some of many
LONGEST = 7  # words of a noun phrase
UNLIKELY = log(0.05)  # that a group as a whole is meant by a word for one of its members
COUNTED = [*NUMBERS]  # words by the number that they stand for
LINKS_OF_A_SPAN = (["to"], ["through"], ["-"])


class Vocabulary:
    """The words for the objects of a scene, and for the members and constants of a library."""

    def __init__(
        self,
        registry: Registry,
        objects: Sequence[SceneObject],
        groups: Mapping[str, Sequence[str]] | None = None,
        own: OwnWords = NONE,
    ) -> None:
        self._registry, self._own = registry, own
        self.types = dict(registry.constants) | {obj.name: obj.type for obj in objects}
        self._sizes = {obj.name: obj.size[0] * obj.size[1] * obj.size[2] for obj in objects}
        traits = {obj.name: dict(obj.traits) for obj in objects}
        self._objects = {
            name: known_words(registry, name, kind, traits.get(name, {}), groups)
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
    def offsets(self) -> frozenset[str]:
        """Return the names of fields that say how far to a side something is."""
        return frozenset(self._own.offsets) & OPPOSITES.keys()

    @property
    def own_nouns(self) -> frozenset[str]:
        """Return the words in the names of fields and of records."""
        return frozenset(word for label in self._own.labels for word in label)

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
            if (count := self._count(tokens, at)) is not None:
                found.append(self._labelled(tokens, count, found[-1].end if found else 0))
                at = found[-1].end
                continue
            ends = range(min(len(tokens), at + LONGEST), at, -1)
            mention = next((each for end in ends if (each := self._mention(tokens, at, end))), None)
            if mention is None:
                at += 1
                continue
            mention = self._more_numbers(tokens, mention)
            mention = self._labelled(tokens, mention, found[-1].end if found else 0)
            whole = self._with_contents(tokens, found[-1], mention) if found else None
            if whole is not None:
                found[-1] = mention = whole
            elif found and found[-1].is_member and self._is_described(found[-1], mention):
                found[-1] = replace(found[-1], end=mention.end)  # "the heavy parcels"
            else:
                found += self._members_of(tokens, mention)
            at = mention.end
        if len(found) > 1 and found[0].end == found[1].begin and self._may_be_verb(tokens, found[0]):
            return found[1:]
        return found

    def _count(self, tokens: Sequence[str], at: int) -> Mention | None:
        """Return the number of "two bolts" where an element has one; None where it is none."""
        if not self._own.takes_counts:
            return None
        number = "1" if tokens[at] == "single" and ("single",) not in self._members else number_of(tokens[at])
        before, after = ("".join(tokens[max(0, n) : n + 1]) for n in (at - 1, at + 1))
        counts = self._names_kind(after) or (before,) in self._own.labels
        if not number or after in UNITS or after in UNIT_WORDS or not counts:
            return None
        if at and self.is_kind(singular(before)):
            return None
        named = [*self._exact(COUNTED[int(number) : int(number) + 1])]
        senses = named or [Sense((float(number),), measures="number")]
        return Mention(at, at + 1, tuple(senses), is_member=True)

    def _names_kind(self, word: str) -> bool:
        return not singulars(word).isdisjoint(self._words | self.own_nouns)

    def _members_of(self, tokens: Sequence[str], mention: Mention) -> list[Mention]:
        """Return the members that describe a noun phrase, where an element has these and not the objects."""
        objects = [value for sense in mention.senses for value in sense.values if value in self.types]
        if not objects or any(self._may_be_field(str(value)) for value in objects):
            return [mention]
        found: list[Mention] = []
        for at in range(mention.begin, mention.end):
            senses = [each for each in self._exact([tokens[at]]) if each.values[0] in self._members.values()]
            if senses:
                begin = at if found else mention.begin
                found.append(Mention(begin, at + 1, tuple(senses), tokens[at], is_member=True))
        if not found:
            return [mention]
        return [*found[:-1], replace(found[-1], end=mention.end, label=mention.label)]

    def _is_described(self, member: Mention, noun: Mention) -> bool:
        """Return whether a noun that no field of an element takes stands right after a member."""
        values = [str(value) for sense in noun.senses for value in sense.values]
        objects = [value for value in values if value in self.types]
        adjoins = member.end == noun.begin and (noun.is_many or len(noun.senses) > 1)
        return adjoins and len(objects) == len(values) and not any(map(self._may_be_field, objects))

    def _may_be_field(self, name: str) -> bool:
        """Return whether an object may be in a field of an element."""
        kinds = self._own.types & self._registry.parents.keys()
        return not self._own.types or any(self._registry.is_a(self.types[name], kind) for kind in kinds)

    def _labelled(self, tokens: Sequence[str], mention: Mention, start: int) -> Mention:
        """Return a noun phrase with the name of a parameter beside it: "a gap of 12 cm", "the far zone"."""
        begin, end = mention.begin, mention.end
        if (beside := self._beside(tokens, mention)) is not None:
            return beside
        own = {*tokens[begin:end]}
        for label in self._own.labels:
            if not own.isdisjoint(label):
                continue
            size = len(label)
            may_be_verb = stem(label[-1]) in VERBS
            is_letter = len(label[0]) == 1  # "u 9 cm", and not "a"
            if is_letter and (size > 1 or not mention.senses[0].is_number):
                continue
            after = tokens[end + size : end + size + 1]
            is_next = bool(after) and (number_of(after[0]) or self._begins_mention(tokens, end + size))
            if _is_same(tokens[end : end + size], label) and not (is_next or may_be_verb or is_letter):
                return replace(mention, end=end + size, label=label)
            is_object = mention.senses[0].values[0] in self.types  # "the twin of the plant" is another
            for link in ((),) if is_object else ((), ("of",)):
                at = begin - size - len(link)
                if at < start or tuple(tokens[begin - len(link) : begin]) != link:
                    continue
                before = "".join(tokens[max(0, at - 1) : at])
                if may_be_verb and before not in DETERMINERS:
                    continue
                if _is_same(tokens[at : at + size], label) and before != "on":
                    while at > start and tokens[at - 1] in DETERMINERS:
                        at -= 1
                    return replace(mention, begin=at, label=label)
        return mention

    def _beside(self, tokens: Sequence[str], mention: Mention) -> Mention | None:
        """Return a noun phrase with the name of a field that is a side: "the near chair", "5 cm ahead"."""
        at = mention.begin - 1
        is_number = mention.senses[0].is_number
        own = self._own.offsets if is_number else self._own.sides
        if at >= 0 and tokens[at] in own:
            before = "".join(tokens[max(0, at - 1) : at])
            if is_number or not before or before in LINKS or before in DETERMINERS:
                return replace(mention, begin=at - (before in DETERMINERS), label=(tokens[at],))
        end = self.side_after(tokens, mention) if is_number else None
        if end is None or tokens[end - 1] not in own or number_of("".join(tokens[end : end + 1])):
            return None
        return replace(mention, end=end, label=(tokens[end - 1],))

    @staticmethod
    def side_after(tokens: Sequence[str], number: Mention) -> int | None:
        """Return where "5 cm to the left" ends that begins with a number; None where it tells no side."""
        at = number.end
        while at < len(tokens) and tokens[at] in {"to", "on", *DETERMINERS}:
            at += 1
        return at + 1 if at < len(tokens) and tokens[at] in OPPOSITES else None

    def _begins_mention(self, tokens: Sequence[str], at: int) -> bool:
        ends = range(at + 1, min(len(tokens), at + LONGEST) + 1)
        return any(self._mention(tokens, at, end) is not None for end in ends)

    def _with_contents(self, tokens: Sequence[str], first: Mention, of: Mention) -> Mention | None:
        """Return "cups of tea", "every cup that has tea in it" as one noun phrase; None where it is none."""
        between = [*tokens[first.end : of.begin]]
        members = {value for sense in of.senses for value in sense.values if value in self._members.values()}
        is_certain = len(first.senses) == 1 and first.senses[0].values[0] in self.types
        if is_certain and not members and between == ["of"] and not of.is_many:
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
        if number := measured(phrase):
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
            is_done = len(member) == 1 and self._is_participle(phrase, name)  # "waxed" of wax
            if is_done or (
                len(member) == len(phrase)
                and all(word in singulars(each) for word, each in zip(member, phrase, strict=True))
            ):
                yield Sense((name,))
                bearers = [other for other, known in self._objects.items() if member[-1] in known.properties]
                if len(member) == 1 and bearers:
                    many = phrase[-1] != member[-1] or len(bearers) == 1
                    yield from one_or_all(bearers, many)

    def _is_participle(self, phrase: Sequence[str], member: str) -> bool:
        """Return whether a word is the participle or the verb of a member that a field takes."""
        if len(phrase) != 1 or stem(phrase[0]) != stem(member) or phrase[0] == member:
            return False
        if not (phrase[0].endswith("ed") or (member.endswith("ed") and phrase[0] == singular(phrase[0]))):
            return False
        return any(member in self._registry.enums.get(each, ()) for each in self._own.types)

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
            yield from one_or_all(found, every or (noun != singular(noun) and not number))

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


def _is_same(tokens: Sequence[str], label: Sequence[str]) -> bool:
    return len(tokens) == len(label) and all(
        word in singulars(token) or word == token or singular(word) == singular(token)
        for word, token in zip(label, tokens, strict=True)
    )
