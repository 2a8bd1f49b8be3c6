"""From sentences to the lists that a program is called with.

A sentence may be a call at any level below the program, or a fact that it is to bring about. Elements of
lists are sought from whose consequences it follows: so neither programs nor predicates are known by name
here. Which object is what in a sentence is weighed by its grammar and held against the declarations' own
wording; of all ways to understand all sentences, the probabilities add up to one.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from math import exp, prod

from ntp_dsl.common.text import shortened
from ntp_dsl.language.diagnostics.diagnostics import NtpError
from ntp_dsl.language.registry import Program, Registry
from ntp_dsl.semantics.observation import Argument, Observation
from ntp_dsl.sentences.clauses import Part
from ntp_dsl.sentences.consequences import Said
from ntp_dsl.sentences.discourse import Discourse
from ntp_dsl.sentences.elements import Element, Elements, Placed
from ntp_dsl.sentences.english import (
    DETERMINERS,
    EVERY,
    FIRM,
    GOALS,
    KNOWN,
    KNOWN_VERBS,
    PREPOSITIONS,
    PRONOUNS,
    Role,
    number_of,
    singulars,
    stem,
    words,
)
from ntp_dsl.sentences.grammar import readings
from ntp_dsl.sentences.matching import Matcher
from ntp_dsl.sentences.mentions import Vocabulary
from ntp_dsl.sentences.narration import example
from ntp_dsl.sentences.own_words import own_words
from ntp_dsl.sentences.refusals import refuse
from ntp_dsl.sentences.senses import Mention
from ntp_dsl.sentences.splitting import split
from ntp_dsl.sentences.ways import Path, Way, by_sentence, followed

MOST_WAYS = 200  # ways to understand one clause, of which some have no element
SURE_ENOUGH = 0.7  # an element that is less probable has to be asked about
LINKING = frozenset({"to", "of", "the", "a", "an", "in", "on"})  # that tell no relation beside another word
RARE = 1e-3  # ways less probable than this are not told


@dataclass(frozen=True)
class Choice:
    """An element of a list, by which sentence it was said, and what it may be instead."""

    sentence: int
    parameter: str
    element: Element
    probability: float
    others: tuple[tuple[Element, float], ...] = ()


@dataclass(frozen=True)
class Understood:
    """What sentences say: the lists, how sure each element is, and the words that were passed over."""

    arguments: tuple[Argument, ...]
    choices: tuple[Choice, ...]
    passed_over: tuple[tuple[int, str], ...] = ()  # of each, its sentence and the word

    @property
    def probability(self) -> float:
        """Return how probable it is that all elements are right, taken for independent."""
        return prod(each.probability for each in self.choices)


@dataclass(frozen=True)
class _Heard:
    """A clause, and what was understood before it."""

    clause: list[str]
    paths: list[Path]
    discourse: Discourse


class Listener:
    """Understands sentences about one scene, for one program.

    Args:
        arguments: of the program; what its lists hold does not count.
        seen: the scene as it is when the sentences are said.
        groups: names of groups of the scene, for words such as "the trays".
    """

    def __init__(
        self,
        registry: Registry,
        program: str,
        arguments: Sequence[Argument],
        seen: Observation,
        groups: Mapping[str, Sequence[str]] | None = None,
    ) -> None:
        self.registry = registry
        self.program: Program = registry.programs[program]
        own = own_words(registry, self.program)
        self.vocabulary = Vocabulary(registry, seen.objects, groups, own)
        self.elements = Elements(registry, self.program, arguments, seen, self.vocabulary.types)
        self._fixed = {each.name for each in seen.objects if not each.movable}
        self._matcher = Matcher(registry, self.program, self.vocabulary.types, self._fixed)
        self._heard = Discourse(self.vocabulary)

    def understand(self, sentences: Sequence[str]) -> Understood:
        """Return what sentences say.

        Raises `NtpError` for one of which nothing that the program may do follows. A program without lists is
        told nothing; yet what is said has to be what it does.
        """
        self._heard = Discourse(self.vocabulary)
        paths = [Path(0.0)]
        passed_over: list[tuple[int, str]] = []
        for number, text in enumerate(sentences):
            refuse(text, number, self.vocabulary, self._matcher)
        clauses = [[*split(words(text), self.vocabulary.mentions)] for text in sentences]
        heard = (tokens for parts in clauses for tokens in parts)
        self.elements.may_be_about(name for tokens in heard for name in self._named_by(tokens))
        following = 0  # the sentence that comes next
        for number, (text, parts) in enumerate(zip(sentences, clauses, strict=True)):
            if number < following:
                continue
            following = number + 1
            told = {number: parts}
            later = [each for some in clauses[number + 1 :] for each in some]
            discourse = self._heard.copy()
            after = followed(self.elements, paths, self._whole_elements(parts), number)
            if not after:
                self._heard = discourse.copy()
                try:
                    after, told[number] = self._in_turn(paths, parts, later, text, number)
                except NtpError:
                    self._heard = discourse
                    after = self._with_next(paths, clauses[number : number + 2], number)
                    if not after:
                        raise
                    told[following] = clauses[following]
                    following += 1
            passed_over += [(at, word) for at in told for part in told[at] for _, word in self._unknown(part)]
            if after is paths and not (self._heard.theme is not None and later):
                raise self._not_understood(text, number, words(text))
            paths = after
        whole = [path for path in paths if path.is_whole]
        if self.elements.lists and not (whole and whole[0].chosen):
            raise NtpError(f"what was said names no whole element: {self._wanted()}")
        return self._told(whole, passed_over)

    def _with_next(self, paths: list[Path], both: Sequence[list[list[str]]], number: int) -> list[Path]:
        """Return the paths that go on with two sentences that tell one element together."""
        if len(both) < 2:
            return []
        return followed(self.elements, paths, self._whole_elements([*both[0], *both[1]]), number)

    def _whole_elements(self, clauses: Sequence[Sequence[str]]) -> list[Way]:
        """Return the ways in which clauses name all fields of one element and nothing else."""
        mentions: list[Mention] = []
        is_other = False
        for said in clauses:
            clause = self._heard.completed(said)
            found = self._heard.mentions(clause)
            mentions += found
            missed = [at for at, word in self._unknown(clause) if not word.endswith("ly")]
            is_other |= any(self._decides(clause, at) for at in missed)
            is_other |= self._relates_otherwise(clause, found)
            if found:
                things = [each for each in found if each.senses[0].values[0] in self.vocabulary.types]
                self._heard.heard(found, (things or found)[0])
        mentions = [each for each in mentions if not _is_named_by_another(each, mentions)]
        once = [
            each for at, each in enumerate(mentions) if each.senses not in [o.senses for o in mentions[:at]]
        ]
        if is_other:
            return []
        whole = self._matcher.whole_elements
        scored = [*whole(once)] or [*whole(mentions)]  # what is said again may be a number of another field
        return [Way(score, meant) for score, meant in scored]

    def _relates_otherwise(self, tokens: Sequence[str], mentions: Sequence[Mention]) -> bool:
        """Return whether a clause relates things as nothing declared does: "beside", a place in a thing."""
        if not mentions:
            return False
        parts = readings(tokens, mentions)[:1]
        roles = [(role, each) for clause in parts for role, each in clause.parts]
        things = [(role, each) for role, each in roles if each.senses[0].values[0] in self.vocabulary.types]
        foreign = any(
            role in FIRM
            and self._matcher.own_words.isdisjoint({*tokens[max(0, each.begin - 3) : each.begin]} - LINKING)
            for role, each in things
        )
        moved = [each for role, each in things if role is Role.THEME]
        goals = [each for role, each in things if role in GOALS]
        fixed = [all(value in self._fixed for value in each.senses[0].values) for each in moved]
        stays = [all(value in self._fixed for value in each.senses[0].values) for each in goals]
        return foreign or (any(fixed) and not all(stays))

    def _in_turn(
        self,
        paths: list[Path],
        clauses: Sequence[list[str]],
        following: Sequence[list[str]],
        text: str,
        number: int,
    ) -> tuple[list[Path], list[list[str]]]:
        """Return the paths that go on with a sentence, and its clauses as they were understood.

        One that says nothing by itself may tell an element together with the one before, or the one after.

        Raises `NtpError` for what is not understood.
        """
        read: list[_Heard] = []
        waiting: NtpError | None = None
        for at, clause in enumerate(clauses):
            now = _Heard(clause, paths, self._heard.copy())
            later = [*clauses[at + 1 :], *following, []][0]
            try:
                if waiting is not None:
                    raise waiting
                paths = self._after(paths, clause, later, text, number)
            except NtpError as error:
                if not read and at + 1 == len(clauses):
                    raise
                if not read:
                    waiting = error
                else:
                    now = replace(read[-1], clause=[*read[-1].clause, ",", *clause])
                    self._heard = now.discourse.copy()
                    try:
                        paths = self._after(now.paths, now.clause, later, text, number, as_element=True)
                    except NtpError:
                        raise error from None
                    read.pop()
                    waiting = None
            read.append(now)
        if waiting is not None:
            raise waiting
        return paths, [each.clause for each in read]

    def clauses_of(self, sentence: str) -> tuple[Understood, frozenset[str]]:
        """Return what those clauses of a sentence say that name something, and what they are about.

        Raises `NtpError` where there is none.
        """
        refuse(sentence, 0, self.vocabulary, self._matcher)
        tokens = words(sentence)
        clauses = [each for each in split(tokens, self.vocabulary.mentions) if self.vocabulary.mentions(each)]
        self.elements.may_be_about(self._named_by(tokens))
        self._heard = Discourse(self.vocabulary)
        paths, themes = [Path(0.0)], set[str]()
        for at, clause in enumerate(clauses):
            paths = self._after(paths, clause, (clauses[at + 1 :] or [[]])[0], sentence, 0)
            theme = self._heard.theme
            values = {str(value) for sense in theme.senses for value in sense.values} if theme else set()
            themes |= values | {str(each) for each in self.elements.traits(values, [*self._members])}
        whole = [path for path in paths if path.is_whole]
        if not (whole and whole[0].chosen):
            raise self._not_understood(sentence, 0, tokens)
        return self._told(whole, []), frozenset(themes)

    def _after(
        self,
        paths: list[Path],
        clause: Sequence[str],
        following: Sequence[str],
        text: str,
        number: int,
        as_element: bool = False,
    ) -> list[Path]:
        """Return the paths that go on with a clause; the same ones where it says nothing by itself.

        Args:
            as_element: it consists of several, which tell the fields of one element.

        Raises `NtpError` for words that nobody knows, and where nothing fits.
        """
        tokens = self._heard.completed(clause)
        unknown = [at for at, word in self._unknown(tokens) if not word.endswith("ly")]
        if any(self._decides(tokens, at) for at in unknown) or self._heard.points_nowhere(tokens):
            raise self._not_understood(text, number, tokens)
        if self._heard.only_points(tokens, following):
            return paths
        if as_element and self._relates_otherwise(tokens, self._heard.mentions(tokens)):
            raise self._not_understood(text, number, tokens)
        ways = self._ways(tokens, as_element)
        if unknown:  # of one thing alone, an unknown verb says nothing
            ways = [way for way in ways if all(each.named > 1 for each in way.meant)]
        after = followed(self.elements, paths, ways, number)
        if not after and self._has_content(tokens):
            raise self._not_understood(text, number, tokens)
        return after or paths

    @property
    def _members(self) -> Iterator[str]:
        return (member for members in self.registry.enums.values() for member in members)

    def _named_by(self, tokens: Sequence[str]) -> Iterator[str]:
        for mention in self.vocabulary.mentions(tokens):
            for sense in mention.senses:
                yield from (value for value in sense.values if isinstance(value, str))

    def _decides(self, tokens: Sequence[str], at: int) -> bool:
        """Return whether what a clause means hangs on an unknown word: a noun, a relation, the only verb."""
        before, after = tokens[at - 1] if at else "", tokens[at + 1] if at + 1 < len(tokens) else ""
        if before == "'s" or number_of(before):
            return True
        if before in (DETERMINERS | EVERY) - PRONOUNS or (before != "to" and (before,) in PREPOSITIONS):
            return True
        mentions = self._heard.mentions(tokens)
        relates = any(each.begin == at + 1 for each in mentions) and any(each.end <= at for each in mentions)
        related = any((word,) in PREPOSITIONS for word in tokens)
        return relates or after.endswith("ing") or (len(mentions) > 1 and not related)

    def _unknown(self, tokens: Sequence[str]) -> list[tuple[int, str]]:
        """Return the words that mean nothing here, with their places."""
        inside = {at for each in self._heard.mentions(tokens) for at in range(each.begin, each.end)}
        verbs = self._matcher.verbs
        return [
            (at, word)
            for at, word in enumerate(tokens)
            if at not in inside and word.isalpha() and word not in KNOWN
            if self._matcher.nouns.isdisjoint(singulars(word))
            if stem(word) not in verbs | KNOWN_VERBS and word not in verbs and not self.vocabulary.knows(word)
        ]

    def _has_content(self, tokens: Sequence[str]) -> bool:
        return bool(self.vocabulary.mentions(tokens) or self._unknown(tokens))

    def _not_understood(self, text: str, number: int, tokens: Sequence[str]) -> NtpError:
        head = f"sentence {number + 1} is not understood: '{shortened(text)}'"
        unknown = [word for _, word in self._unknown(tokens)]
        named = [*dict.fromkeys(self._named_by(tokens))]
        if unknown:
            listed = ", ".join(f"'{word}'" for word in dict.fromkeys(unknown))
            why = f"nothing here is called {listed}"
        elif named:
            why = f"no step or effect of '{self.program.name}' matches; it names {', '.join(named[:6])}"
        else:
            why = "it names no object"
        things = ", ".join(self.vocabulary.things[:12])
        more = len(self.vocabulary.things) - 12
        things += f" and {more} more" if more > 0 else ""
        return NtpError(f"{head}: {why}\n  known things: {things}\n  for example: {self._example()}")

    def _wanted(self) -> str:
        """Say what an element of each list consists of."""
        found = []
        for each in self.elements.lists:
            fields = self.registry.records.get(each.type, (each,))
            found.append(f"one of '{each.name}' is {' and '.join(f'a {field.type}' for field in fields)}")
        return ", ".join(found)

    def _example(self) -> str:
        calls = [form.name for form in self._matcher.forms if not form.is_fact and not form.is_element]
        return example(self.registry, self.program, calls)

    def _ways(self, tokens: Sequence[str], as_element: bool) -> list[Way]:
        """Return the ways to understand a clause, the likeliest first."""
        mentions = self._heard.mentions(tokens)
        if not mentions:
            return []
        best: dict[tuple[Said, ...], float] = {}
        ways_to_read = readings(tokens, mentions)
        if not ways_to_read:
            return []
        is_other = self._relates_otherwise(tokens, mentions)
        self._heard.heard(mentions, self._theme(ways_to_read[0].parts) or mentions[0])
        for clause in ways_to_read:
            for score, meant in self._matcher.meant_by(clause, as_element, is_other):
                if score > best.get(meant, float("-inf")):
                    best[meant] = score
        found = [Way(score, meant) for meant, score in best.items()]
        return sorted(found, key=lambda way: -way.score)[:MOST_WAYS]

    def _theme(self, parts: Sequence[Part]) -> Mention | None:
        """Return what a clause is about: what gets somewhere, if it may move at all."""
        themes = [each for role, each in parts if role is Role.THEME]
        goals = [each for role, each in parts if role in GOALS]
        moving = [
            each for each in (*themes, *goals) if self._fixed.isdisjoint(map(str, each.senses[0].values))
        ]
        return next(iter(moving or themes), None)

    def _told(self, paths: Sequence[Path], passed_over: Sequence[tuple[int, str]]) -> Understood:
        """Return the likeliest way to understand everything, and what may be instead of each element."""
        top = paths[0].score
        weights = [exp(each.score - top) for each in paths]
        total = sum(weights)
        shares: dict[tuple[int, int], dict[Placed, float]] = defaultdict(lambda: defaultdict(float))
        for path, weight in zip(paths, weights, strict=True):
            for key, placed in by_sentence(path).items():
                shares[key][placed] += weight / total
        choices = []
        for key, placed in by_sentence(paths[0]).items():
            alike = {each for each in shares[key] if self.elements.mean_the_same(each, placed)}
            chance = sum(shares[key][each] for each in alike)
            others = [
                (each[1], share)
                for each, share in sorted(shares[key].items(), key=lambda pair: -pair[1])
                if each not in alike and each[0] == placed[0] and share > RARE
            ]
            choices.append(Choice(key[0], *placed, min(chance, 1.0), tuple(others)))
        return Understood(self.with_elements(choices), tuple(choices), tuple(dict.fromkeys(passed_over)))

    def with_elements(self, choices: Sequence[Choice]) -> tuple[Argument, ...]:
        """Return the program's arguments, with the elements that were chosen in its lists."""
        lists: dict[str, tuple[Element, ...]] = defaultdict(tuple)
        for each in choices:
            if each.element not in lists[each.parameter]:
                lists[each.parameter] += (each.element,)
        return self.elements.called_with(lists)


def _is_named_by_another(mention: Mention, mentions: Sequence[Mention]) -> bool:
    """Return whether a noun may stand for what another names: "brush it with brush 1"."""
    others = [each.senses[0].values for each in mentions if len(each.senses) == 1]
    return len(mention.senses) > 1 and any(each.values in others for each in mention.senses)
