"""What was spoken of before: "it", "which", "the other one", and clauses that only point at something."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from math import log

from ntp_dsl.sentences.english import (
    ATTENTION,
    BEARING,
    DETERMINERS,
    FILLERS,
    HANDLING,
    ONES,
    ORDINALS,
    PREPOSITIONS,
    PRONOUNS,
    RELATIONS,
    SITES,
    stem,
)
from ntp_dsl.sentences.mentions import Vocabulary
from ntp_dsl.sentences.senses import Mention, Sense

SEVERAL = frozenset("they them these those".split())
POINTING = frozenset({"the", "that", "this"})
SO_DOES = frozenset("do does is are should must will".split())
BEING = frozenset("is what should will must can".split())


class Discourse:
    """The noun phrases of a run of sentences, as far as it was heard."""

    def __init__(self, vocabulary: Vocabulary) -> None:
        self._vocabulary = vocabulary
        self.theme: Mention | None = None  # what the clause before was about
        self._before: list[Mention] = []  # and what it named
        self._named: set[str] = set()
        self._all_themes: list[str] = []  # what clauses were about, in their order
        self._latest_list: list[str] = []  # the latest of which several were named at once

    def copy(self) -> Discourse:
        """Return another that has heard the same."""
        found = Discourse(self._vocabulary)
        found.theme, found._before, found._named = self.theme, [*self._before], {*self._named}
        found._all_themes, found._latest_list = [*self._all_themes], [*self._latest_list]
        return found

    def heard(self, mentions: Sequence[Mention], theme: Mention) -> None:
        """Remember a clause's noun phrases, and what it was about."""
        self.theme, self._before = theme, [*mentions]
        certain = (sense for each in mentions if len(each.senses) == 1 for sense in each.senses)
        self._named |= {str(value) for sense in certain for value in sense.values}
        if len(theme.senses) == 1:
            about = [str(value) for value in theme.senses[0].values]
            self._all_themes += [each for each in about if each not in self._all_themes]
            self._latest_list = about if len(about) > 1 else self._latest_list

    def completed(self, tokens: Sequence[str]) -> list[str]:
        """Return a clause with what goes without saying: "the cup on top" is on top of it."""
        found = list(tokens)
        if found[:1] == ["so"] and "".join(found[1:2]) in SO_DOES:  # "so does the cup"
            found = [*found[2:], "to", "there"]
        if self.theme is None or len(self._vocabulary.mentions(found)) != 1:
            return found
        if "there" in found[1:]:  # "put it there", "in there"
            at = found.index("there", 1)
            relation = [] if (found[at - 1],) in PREPOSITIONS else ["to"]
            return [*found[:at], *relation, "there", *found[at + 1 :]]
        if found[-2:] == ["on", "top"]:
            return [*found, "of", "it"]
        return [*found, "it"] if found[-1:] in (["inside"], ["in"], ["on"]) else found

    def points_nowhere(self, tokens: Sequence[str]) -> bool:
        """Return whether "the third" is said where only two were named."""
        inside = {at for each in self.mentions(tokens) for at in range(each.begin, each.end)}
        return any(
            word in ORDINALS and tokens[at - 1 : at] == ["the"] and at not in inside
            for at, word in enumerate(tokens)
            if not self._vocabulary.knows("".join(tokens[at + 1 : at + 2]))
        )

    def only_points(self, tokens: Sequence[str], following: Sequence[str]) -> bool:
        """Return whether a clause only says what the next one is about: "find the tray", "take it, and …".

        Args:
            following: the next clause, which may say "it".
        """
        mentions = self.mentions(tokens)
        inside = {at for each in mentions for at in range(each.begin, each.end)}
        outside = [word for at, word in enumerate(tokens) if at not in inside]
        if len(mentions) != 1:
            return False
        verbs = {stem(word) for word in outside if word not in FILLERS | SITES | RELATIONS}
        related = any((word,) in PREPOSITIONS for word in outside)
        told_next = not PRONOUNS.isdisjoint(following) and not self._names(following, mentions[0])
        points = verbs <= ATTENTION and (bool(verbs) or not related or not SITES.isdisjoint(outside))
        if not points and not (told_next and verbs <= HANDLING and not related):
            return False
        self.heard(mentions, mentions[0])
        return True

    def _names(self, tokens: Sequence[str], mention: Mention) -> bool:
        """Return whether a clause names a thing again, where a pronoun would do."""
        return any(each.senses == mention.senses for each in self._vocabulary.mentions(tokens))

    def mentions(self, tokens: Sequence[str]) -> list[Mention]:
        """Return the noun phrases of a clause, "it" and "the other one" among them."""
        found = self._vocabulary.mentions(tokens)
        inside = {at for each in found for at in range(each.begin, each.end)}
        for at, word in enumerate(tokens):
            if at in inside:
                continue
            mention = None
            if word == "other":
                mention = self._other(tokens, at, found)
            elif word in ORDINALS and tokens[at - 1 : at] == ["the"]:
                mention = self._ordinal(tokens, at)
            elif word == "which" and at == 0 and self._before:
                mention = _again(self._before[-1], at)
            elif word == "there" and tokens[at - 1 : at] == ["to"] and self.theme is not None:
                mention = _again(self._place(), at)
            elif word == "that" and at and tokens[at + 1 : at + 2] == ["one"] and self.theme is not None:
                mention = replace(_again(self.theme, at), end=at + 2)
            elif self._is_pronoun(tokens, at):
                mention = self._it(tokens, at, found)
            if mention is not None:
                found.append(mention)
                inside |= {*range(mention.begin, mention.end)}
        return sorted((self._spoken_of(tokens, each, found) for each in found), key=lambda each: each.begin)

    def _spoken_of(self, tokens: Sequence[str], mention: Mention, beside: Sequence[Mention]) -> Mention:
        """Return a noun phrase as what was spoken of, where it may be that: "put the brush back"."""
        if len(mention.senses) == 1 or mention.is_many or tokens[mention.begin] not in POINTING:
            return mention
        here = [each.senses[0].values for each in beside if len(each.senses) == 1]
        equated = not {"is", "be", "are"}.isdisjoint(tokens)
        if equated and any(each.values in here for each in mention.senses):
            return mention  # "the object on the tray has to be the cup"
        before = {value for each in self._before if len(each.senses) == 1 for value in each.senses[0].values}
        for known in (before, self._named):
            found = [each for each in mention.senses if known.issuperset(each.values)]
            if len(found) == 1:
                return replace(mention, senses=(replace(found[0], weight=0.0),))
            if found:
                return mention
        return mention

    def _place(self) -> Mention:
        """Return where the clause before brought something, or what it was about."""
        assert self.theme is not None
        others = [each for each in self._before if each.senses != self.theme.senses]
        return others[-1] if others else self.theme

    def _is_pronoun(self, tokens: Sequence[str], at: int) -> bool:
        after = tokens[at + 1 : at + 2]
        if tokens[at] in DETERMINERS:  # "on that", "that is", and not "that cup"
            is_noun = bool(after) and (self._vocabulary.knows(after[0]) or after[0] in ONES | SITES)
            ends = not is_noun if at else bool(after) and after[0] in BEING
            return tokens[at] in PRONOUNS and ends
        return tokens[at] in PRONOUNS and after != ["that"]

    def _it(self, tokens: Sequence[str], at: int, found: Sequence[Mention]) -> Mention | None:
        """Return what a pronoun stands for where that is nothing in its own clause."""
        if self.theme is None:
            return None
        is_first = all(each.begin > at for each in found) and len(found) < 2  # "it is the cup that …"
        is_alone = len(found) == 1 and at > 0 and not any(stem(word) in BEARING for word in tokens)
        if not (is_first or is_alone):
            return None
        if tokens[at] in SEVERAL and not self.theme.is_many:  # "they go on shelves 0 and 1"
            count = max((len(each.senses[0].values) for each in found if each.is_many), default=0)
            if 1 < count <= len(self._all_themes):
                return Mention(at, at + 1, (Sense(tuple(self._all_themes[-count:])),), self.theme.head, True)
        here = [each.senses for each in found]
        spoken_of = (each for each in (self.theme, *self._before) if each.senses not in here)
        return _again(next(spoken_of, self.theme), at)

    def _ordinal(self, tokens: Sequence[str], at: int) -> Mention | None:
        """Return what "the second" of several that were named stands for; None where it is no noun."""
        after = "".join(tokens[at + 1 : at + 2])
        if after and after not in ONES and self._vocabulary.knows(after):
            return None
        values = self._latest_list or self._all_themes
        number = ORDINALS[tokens[at]]
        is_of_two = tokens[at] in ("former", "latter")
        if len(values) < 2 or number >= len(values) or (is_of_two and len(values) > 2):
            return None
        return Mention(at - 1, at + 1 + (after in ONES), (Sense((values[number],)),))

    def _other(self, tokens: Sequence[str], at: int, found: list[Mention]) -> Mention | None:
        """Return what "the other one" stands for: what is of the same kind, and was not named yet."""
        after = [each for each in found if each.begin == at + 1]
        before = [each for each in found if each.end <= at] or [
            *self._before,
            *([self.theme] if self.theme else []),
        ]
        heads = [after[0].head] if after else [each.head for each in reversed(before)]
        here = {value for each in before for sense in each.senses for value in sense.values}
        for head in filter(None, heads):
            kinds = self._vocabulary.mentions([head])
            all_of_it = [*dict.fromkeys(v for each in kinds for sense in each.senses for v in sense.values)]
            values = [each for each in all_of_it if each not in here]
            values = [each for each in values if each not in self._named] or values
            if values:
                break
        else:
            return None
        begin = at - 1 if at and tokens[at - 1] in DETERMINERS else at
        end = after[0].end if after else at + 1 + any(tokens[at + 1 : at + 2] == [each] for each in ONES)
        if after:
            found.remove(after[0])
        return Mention(begin, end, tuple(Sense((v,), -log(len(values))) for v in values), head)


def _again(mention: Mention, at: int) -> Mention:
    """Return a noun phrase where a pronoun stands for it."""
    return Mention(at, at + 1, mention.senses, mention.head, mention.is_many)
