"""How clauses are taken apart, by the grammar of English.

The same rules take apart what a person says and what a declaration says, so that the two can be compared.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise

from ntp_dsl.sentences.clauses import Clause, Part, merged, without_source
from ntp_dsl.sentences.english import (
    BEARING,
    COMMON,
    COVERING,
    DETERMINERS,
    EVERY,
    FILLERS,
    FIRM,
    GIVING,
    GOALS,
    LEAVING,
    ONES,
    OPENINGS,
    PASSIVE,
    PREPOSITIONS,
    PRONOUNS,
    RESERVING,
    SITES,
    TAKING,
    Role,
    singular,
    stem,
)
from ntp_dsl.sentences.senses import Mention, Sense
from ntp_dsl.sentences.splitting import is_a_tower, is_link, level_after, upwards

KEPT = PASSIVE | {"meant", "reserved", "intended", "kept", "there", "just", "only"}  # "… for the cups"
WHEREVER = frozenset({"where", "wherever", "whatever"})
ARTICLES = frozenset({"a", "an", "the"})
TOP_AFTER = DETERMINERS | {"on", "at", "to"}
TURNED = {Role.THEME: Role.ON, Role.ON: Role.THEME}
SECOND = -1.5  # for what a verb may mean as well
VAGUE = 2  # things that a word may stand for, so that it is passed over where two others are named
ADVERBS = {
    ("at", "the", "top"): Role.ON,
    ("at", "the", "bottom"): Role.UNDER,
    ("on", "the", "bottom"): Role.UNDER,
}
LONGEST_PREPOSITION = max(map(len, PREPOSITIONS))


def readings(tokens: Sequence[str], mentions: Sequence[Mention]) -> list[Clause]:
    """Return the ways to take a clause apart, given its noun phrases."""
    found = [*_Parser(tokens, mentions).readings()]
    found += [shorter for each in found if (shorter := without_source(each)) is not None]
    listed = frozenset((a, b) for a, b in pairwise(mentions) if is_link(tokens[a.end : b.begin]))
    return [merged(replace(each, mentions=tuple(mentions), listed=listed)) for each in found]


class _Parser:
    def __init__(self, tokens: Sequence[str], mentions: Sequence[Mention]) -> None:
        self.tokens = tokens
        own = [each for each in mentions if not self._is_site_noun(each)]
        equated = not {"is", "be", "are"}.isdisjoint(tokens)
        named = [each for each in own if not (equated and _is_vague(each, own))]
        self.mentions = named if len(named) > 1 else own  # "the object on the tray has to be the cup"
        self.covered = {at for each in self.mentions for at in range(each.begin, each.end)}
        self.markers = {id(each): self._marker(each.begin) for each in self.mentions}
        self.verbs = [
            (at, word, stem(word))
            for at, word in enumerate(tokens)
            if at not in self.covered and word.isalpha() and not self._is_noun(at)
        ]
        self.content = frozenset(
            base
            for _, word, base in self.verbs
            if word not in FILLERS | OPENINGS | PRONOUNS | ONES | EVERY or base in BEARING | COVERING
        )

    def _is_noun(self, at: int) -> bool:
        """Return whether a word is no verb: that of "on top of", and what an article precedes."""
        before, after = self.tokens[max(0, at - 1) : at], self.tokens[at + 1 : at + 2]
        if self.tokens[at] == "top" and after == ["of"]:
            return True
        return bool(before) and before[0] in (TOP_AFTER if self.tokens[at] == "top" else ARTICLES)

    def _is_site_noun(self, mention: Mention) -> bool:
        """Return whether it is a word for a place that another noun phrase owns: "the seat of"."""
        if mention.end - mention.begin > 2 or mention.head not in SITES or len(mention.senses) == 1:
            return False
        if {"is", "be", "are", "has", "have"}.isdisjoint(self.tokens):
            return False
        after = self.tokens[mention.end : mention.end + 1]
        before = self.tokens[max(0, mention.begin - 1) : mention.begin]
        return (
            after in (["of"], ["for"], ["where"]) or before == ["'s"] or self.tokens[mention.begin] == "its"
        )

    def _marker(self, begin: int) -> tuple[Role, str] | None:
        """Return the role that the preposition before a noun phrase gives it, and the preposition."""
        for length in range(LONGEST_PREPOSITION, 0, -1):
            at = range(max(0, begin - length), begin)
            words = tuple(self.tokens[n] for n in at if n not in self.covered)
            if len(words) == length and words in PREPOSITIONS:
                role = PREPOSITIONS[words]
                is_apart = role is Role.FROM and self._is_a_length(begin - length)  # "10 cm from the fire"
                return Role.OF if is_apart else role, " ".join(words)
        return None

    def _is_a_length(self, end: int) -> bool:
        """Return whether a noun phrase that ends at a word is a length."""
        return any(each.end == end and each.senses[0].measures == "length" for each in self.mentions)

    def _role(self, mention: Mention) -> Role | None:
        marker = self.markers[id(mention)]
        return marker[0] if marker is not None else self._listed_with(mention)

    def _listed_with(self, mention: Mention) -> Role | None:
        """Return the role of the noun phrase that this one is listed with: "on the cup and the plate"."""
        at = self.mentions.index(mention)
        if at and self._are_listed(self.mentions[at - 1], mention):
            return self._role(self.mentions[at - 1])
        return None

    def _are_listed(self, first: Mention, second: Mention) -> bool:
        """Return whether noun phrases of one kind stand beside each other: "the cup and the plate"."""
        return first.is_member == second.is_member and is_link(self.tokens[first.end : second.begin])

    @property
    def unmarked(self) -> list[Mention]:
        return [each for each in self.mentions if self._role(each) is None]

    def readings(self) -> list[Clause]:
        for rule in (
            self._ordered,
            self._chained,
            self._site,
            self._elliptic,
            self._bearing,
            self._covering,
            self._giving,
        ):
            parts = rule()
            if parts is not None:
                found = [Clause(tuple(parts), self.content)]
                if rule == self._bearing and not TAKING.isdisjoint(self.content):
                    other_way = tuple((TURNED.get(role, role), each) for role, each in parts)
                    found.append(Clause(other_way, self.content, weight=SECOND))
                return found
        if any(self._is_elsewhere(each) for each in self.mentions):
            return []  # where another thing is, nobody knows
        plain = self._plain()
        is_firm = any(role in FIRM for role, _ in plain)
        found = [Clause(tuple(plain), self.content, is_firm=is_firm)]
        if [role for role, _ in plain].count(Role.UNDER) == 1:  # what is under something else carries it
            turned = {Role.UNDER: Role.THEME, Role.THEME: Role.ON}
            inverse = tuple((turned.get(role, role), each) for role, each in plain)
            found.append(Clause(inverse, self.content, is_firm=True))
        roles = [role for role, _ in plain]
        if len(roles) == 2 and {*roles} == {Role.THEME, Role.WITH}:  # "stack a with b": which is on which?
            turned = {Role.WITH: Role.THEME, Role.THEME: Role.WITH}
            found.append(Clause(tuple((turned[role], each) for role, each in plain), self.content))
        return found

    def _ordered(self) -> list[Part] | None:
        """Take apart "from bottom to top: the tray, the plate, the cup"."""
        if is_a_tower(self.tokens):
            return self._tower()
        rising = upwards(self.tokens)
        related = any(self.markers[id(each)] is not None for each in self.mentions[1:])
        if rising is None or len(self.mentions) < 2 or related:
            return None
        order = self.mentions if rising else self.mentions[::-1]
        pairs = zip(order, order[1:], strict=False)
        return [part for below, above in pairs for part in ((Role.THEME, above), (Role.ON, below))]

    def _tower(self) -> list[Part]:
        """Take apart "stack the bowls on the tray, bowl 1 at the bottom and bowl 2 at the top".

        There are no parts where it is not told of everything that is named where in the tower it stands.
        """
        levels = [(level_after(self.tokens, each.end), each) for each in self.mentions]
        bottom, middle, top = ([each for level, each in levels if level == at] for at in range(3))
        told = [*bottom, *middle, *top]
        rest = [each for level, each in levels if level is None]
        below = [each for each in rest if self._role(each) is Role.ON and not each.is_many]
        listed = {value: each for each in rest if each not in below for value in each.senses[0].values}
        named = [value for each in told for value in each.senses[0].values]
        left = [value for value in listed if value not in named]
        is_certain = all(len(each.senses) == 1 for each in (*told, *rest))
        if not is_certain or len({*named}) < len(told) or len(named) > len(told) or len(below) > 1:
            return []
        if len(bottom) != 1 or len(top) != 1 or len(left) + len(middle) > 1:
            return []
        if listed and not {*named} <= listed.keys():
            return []
        middle += [replace(listed[value], senses=(Sense((value,)),), is_many=False) for value in left]
        order = [*below, *bottom, *middle, *top]
        return [part for under, above in pairwise(order) for part in ((Role.THEME, above), (Role.ON, under))]

    def _chained(self) -> list[Part] | None:
        """Take apart "the cup on the plate on the tray"."""
        roles = [self.markers[id(each)] for each in self.mentions]
        if len(roles) < 3 or roles[0] is not None or len({each and each[0] for each in roles[1:]}) > 1:
            return None
        relation = roles[1]
        pairs = [*zip(self.mentions, self.mentions[1:], strict=False)]
        together = all(b.begin - a.end <= LONGEST_PREPOSITION for a, b in pairs)
        if relation is None or relation[0] not in (Role.ON, Role.IN) or not together:
            return None
        if any(stem(word) in BEARING | COMMON for at, word, _ in self.verbs if at > self.mentions[0].end):
            return None
        return [part for a, b in pairs for part in ((Role.THEME, a), (relation[0], b))]

    def _is_elsewhere(self, mention: Mention) -> bool:
        """Return whether another thing's place is meant, as in "where the cup is"."""
        before = [word for word in self.tokens[: mention.begin] if word not in DETERMINERS]
        noun = self.tokens[mention.end - 1]
        is_plural = mention.is_many or noun != singular(noun)
        return not is_plural and bool(before) and before[-1] in WHEREVER

    def _site(self) -> list[Part] | None:
        """Take apart "the tray is the place for the cup", "where the cup goes is the tray"."""
        theme = None
        for each in self.mentions:
            before, after = self.tokens[: each.begin], self.tokens[each.end :]
            words = [word for at, word in enumerate(self.tokens) if at not in self.covered]
            nearest = [word for word in before if word not in DETERMINERS][-2:]
            is_for, names_a_site = nearest[-1:] == ["for"], not SITES.isdisjoint(words)
            kept = not RESERVING.isdisjoint(map(stem, words)) and self.unmarked[:1] != [each]
            alone = not self.content and each is not self.mentions[0]  # "the other one for the cup"
            for_whom = KEPT.union(nearest[:1] if "use" in words else ())
            named = (
                (is_for and (names_a_site or kept or nearest[0] in for_whom or alone))
                or (nearest[-1:] == ["of"] and nearest[0] in SITES)
                or (names_a_site and nearest in (["belongs", "to"], ["belong", "to"]))
                or (kept and nearest[:1] == ["for"] and nearest[-1].endswith("ing"))
            )
            owned = after[:1] == ["'s"] and not SITES.isdisjoint(after)
            served = "use" in before and self._nearest_word(before[:-1]) == "to" and before[-1].isalpha()
            if named or owned or served or self._is_where(before):
                theme = each
        if theme is None or len(self.mentions) < 2:
            return None
        return [(Role.THEME if each is theme else Role.TO, each) for each in self.mentions]

    def _is_where(self, before: Sequence[str]) -> bool:
        """Return whether a noun phrase's own place is told: "the tray is where", "where the cup goes is"."""
        near = [word for word in before if word not in DETERMINERS][-2:]
        return near[-1:] == ["where"] and (len(near) == 1 or near[0] in PASSIVE | SITES)

    def _nearest_word(self, before: Sequence[str]) -> str:
        return next((word for word in reversed(before) if word not in DETERMINERS), "")

    def _elliptic(self) -> list[Part] | None:
        """Take apart "the tray has the cup on it", "what the cup stands on is the tray", "… on top"."""
        if len(self.mentions) < 2:
            return None
        for at in range(len(self.tokens)):
            found = self._adverb(at)
            if found is None:
                continue
            role, after, is_it = found
            before = [each for each in self.mentions if each.end <= at]
            if not before or not PRONOUNS.isdisjoint(self.tokens[before[-1].end : at]):
                continue  # "… or put it on top"
            near = before[-1]
            if self._role(near) not in (None, Role.WITH, Role.OF):
                continue  # "in the box, or on the heap in it"
            others = [each for each in self.mentions if each is not near]
            if not self._is_list(others) or any(self._role(each) in FIRM for each in others):
                return None
            if any(self._role(each) in (Role.ON, Role.IN) for each in others if each.begin > at):
                continue
            if is_it and all(each.begin >= after for each in others):  # "the tray, and on it the cup"
                near_role, other_role = (Role.THEME, Role.ON) if role is Role.UNDER else (role, Role.THEME)
            else:
                near_role, other_role = (Role.ON, Role.THEME) if role is Role.UNDER else (Role.THEME, role)
            return [(near_role if each is near else other_role, each) for each in self.mentions]
        return None

    def _is_list(self, mentions: Sequence[Mention]) -> bool:
        """Return whether each noun phrase is listed with the one before."""
        pairs = zip(mentions, mentions[1:], strict=False)
        return all(is_link(self.tokens[a.end : b.begin]) for a, b in pairs)

    def _adverb(self, at: int) -> tuple[Role, int, bool] | None:
        """Return a preposition's relation where no noun phrase follows, its end, and whether "it" does."""
        if at in self.covered:
            return None
        for words, role in ADVERBS.items():
            if tuple(self.tokens[at : at + len(words)]) == words:
                return role, at + len(words), False
        relation = PREPOSITIONS.get((self.tokens[at],))
        if relation not in (Role.ON, Role.IN, Role.UNDER):
            return None
        end = at + 1
        while end < len(self.tokens) and end not in self.covered and self.tokens[end] in ("top", "of"):
            end += 1
        is_it = end < len(self.tokens) and end not in self.covered and self.tokens[end] in PRONOUNS
        if is_it or self._ends_relative(at):
            return relation, end + is_it, is_it
        follows = end in self.covered or (end < len(self.tokens) and (self.tokens[end],) in PREPOSITIONS)
        return None if follows else (relation, end, False)

    def _ends_relative(self, at: int) -> bool:
        """Return whether a preposition ends a relative clause: the next word is a verb or a stop."""
        after = self.tokens[at + 1 : at + 2]
        return not after or after[0] in (",", "is", "should", "must", "will", "are", "be")

    def _subject(self, at: int) -> Mention | None:
        found = [each for each in self.unmarked if each.end <= at]
        return found[-1] if found else None

    def _object(self, at: int) -> Mention | None:
        return next((each for each in self.unmarked if each.begin > at), None)

    def _is_passive(self, at: int) -> bool:
        word = self.tokens[at]
        before = [each for each in self.tokens[max(0, at - 3) : at] if each in PASSIVE]
        is_participle = word.endswith(("ed", "en")) or (stem(word) != word and not word.endswith("ing"))
        return bool(before) and is_participle

    def _bearing(self) -> list[Part] | None:
        """Take apart "the tray carries the cup", "the cup is carried by the tray"."""
        for at, _, base in self.verbs:
            if base not in BEARING:
                continue
            if self._is_passive(at):
                bearer = [each for each in self.mentions if self.markers[id(each)] == (Role.BESIDE, "by")]
                subject = self._subject(at)
                if bearer and subject is not None:
                    return self._as({id(bearer[0]): Role.ON, id(subject): Role.THEME})
                continue
            subject, borne = self._subject(at), self._object(at)
            if subject is not None and borne is not None:
                listed = {id(each): Role.THEME for each in self.unmarked if each.begin > at}
                return self._as(listed | {id(subject): Role.ON, id(borne): Role.THEME})
        return None

    def _covering(self) -> list[Part] | None:
        """Take apart "top the tray with the cup", "the cup tops the tray", "the tray is topped with it"."""
        used = [(at, base) for at, _, base in self.verbs if base in COVERING]
        with_whom = [each for each in self.mentions if self._role(each) is Role.WITH]
        if used:
            at = used[0][0]
            subject, covered = self._subject(at), self._object(at)
            by = [each for each in self.mentions if self.markers[id(each)] == (Role.BESIDE, "by")]
            if with_whom and (covered or subject):
                return self._as({id(covered or subject): Role.ON, **{id(e): Role.THEME for e in with_whom}})
            if by and subject is not None and self._is_passive(at):
                return self._as({id(subject): Role.ON, id(by[0]): Role.THEME})
            if subject is not None and covered is not None:
                return self._as({id(subject): Role.THEME, id(covered): Role.ON})
        return None

    def _giving(self) -> list[Part] | None:
        """Take apart "give the tray the cup"."""
        at = next((at for at, _, base in self.verbs if base in GIVING), None)
        if at is None or self._subject(at) is not None:
            return None
        given = self.unmarked
        if len(given) != 2 or len(self.mentions) != 2:
            return None
        return self._as({id(given[0]): Role.TO, id(given[1]): Role.THEME})

    def _as(self, roles: dict[int, Role]) -> list[Part]:
        return [(roles.get(id(each)) or self._role(each) or Role.OBJECT, each) for each in self.mentions]

    def _plain(self) -> list[Part]:
        """Take apart whatever else: the first noun phrase without a preposition is what it is about."""
        parts: list[Part] = []
        theme: Mention | None = None
        if not self.content and len(self.mentions) == 2 and len(self.unmarked) == 2:  # "seat 2: guest 1"
            return [(Role.OBJECT, each) for each in self.mentions]
        for each in self.mentions:
            role = self._role(each)
            if role is None and all(sense.is_number for sense in each.senses):
                role = Role.OBJECT
            elif role is None and theme is None:
                role = Role.THEME
            elif role is None:
                assert theme is not None
                if not LEAVING.isdisjoint(self.content):
                    parts.append((Role.FROM, each))
                    continue
                run = [other for other in self.mentions if theme.begin <= other.begin <= each.begin]
                listed = self._are_listed(theme, each) or (len(run) > 2 and self._is_list(run))
                role = Role.THEME if listed else Role.OBJECT
            if role is Role.THEME:
                theme = each
            parts.append((role, each))
        roles = [role for role, _ in parts]
        if theme is None and len(parts) == 2 and roles[0] is roles[1] and roles[0] in GOALS:
            return [parts[0], (Role.THEME, parts[1][1])]  # "on top of the tray, the cup"
        if theme is None and roles.count(Role.WITH) == 1:  # "with the cup on the tray"
            return [(Role.THEME if role is Role.WITH else role, each) for role, each in parts]
        return parts


def _is_vague(mention: Mention, others: Sequence[Mention]) -> bool:
    """Return whether a noun may stand for many things, among them what another noun phrase names."""
    may_be = {value for sense in mention.senses for value in sense.values}
    named = [
        {value for sense in each.senses for value in sense.values} for each in others if each is not mention
    ]
    return len(mention.senses) >= VAGUE and any(each < may_be for each in named)
