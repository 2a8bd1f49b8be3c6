"""What a clause may mean: declarations that say something of the kind, with what was named in place."""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import cached_property
from itertools import permutations, product
from operator import itemgetter

from ntp_dsl.language.registry import Api, Parameter, Program, Registry, bounds
from ntp_dsl.language.syntax import nodes
from ntp_dsl.language.syntax.visitors import innermost, predicates
from ntp_dsl.sentences.clauses import Clause, respective, with_each
from ntp_dsl.sentences.consequences import Said
from ntp_dsl.sentences.english import ATTENTION, COMMON, FIRM, GOALS, Role, name_words, with_synonyms
from ntp_dsl.sentences.forms import Form, Wording, form_of, form_of_elements
from ntp_dsl.sentences.senses import Mention, Sense

UNDERSTOOD = -2.5  # the least score with which a clause counts as understood
VERB = 2.0  # for a verb that a declaration uses; an ordinary one is shared among all that use it
SYNONYM = 1.0  # for one that says much the same
TURNED = -2.0  # for two numbers that are not in the declared order
TWICE = -3.0  # for one object in two places
AT_ODDS = -3.0  # a cost of grammar that types do not make good
EASE = 0.3  # of what grammar says counts where types alone tell what is what
NAMED = 1.5  # for a noun phrase with the name of the parameter: "ground white", "the far zone"
LONG = 3  # fields of an element that is told by naming all of them, whatever is said about them
ELEMENT = -1.0  # for what tells an element by its fields alone
OPEN = -0.7  # for a parameter that the clause does not name
UNWORDED = -0.5  # for a parameter of which a wording says nothing
MOST = 60  # calls or facts that one clause may mean together

Scored = tuple[float, tuple[Said, ...]]  # the logarithm of how well something fits, and what it means


class Matcher:
    """Compares clauses with what a program calls at any level, and with what all of these achieve.

    Args:
        types: of objects and constants by name.
        fixed: objects that never move.
    """

    def __init__(
        self,
        registry: Registry,
        program: Program,
        types: Mapping[str, str],
        fixed: Collection[str] = (),
    ) -> None:
        self.registry, self.program, self.types, self._fixed = registry, program, types, fixed

    @cached_property
    def forms(self) -> list[Form]:
        """What can be said of the program: what it calls at any level, and what these achieve."""
        below = self.registry.called_by(self.program.name)
        if self.program.takes_list:
            below -= {self.program.name}
        facts: set[str] = set()
        for name in [self.program.name, *below]:
            waiting = {*predicates(self.registry[name].achieves)}
            while waiting:
                predicate = waiting.pop()
                if predicate not in facts:
                    facts.add(predicate)
                    waiting |= {*predicates(self.registry.predicates[predicate].body)}
        found = [form_of(self.registry, name, False, _texts(self.registry[name])) for name in sorted(below)]
        for name in sorted(facts):
            declared = self.registry.predicates[name]
            if declared.result is None:
                found.append(form_of(self.registry, name, True, [declared.docstring or ""]))
        lists = [each for each in self.program.parameters if each.is_list]
        found += [form_of_elements(self.registry, each) for each in lists]
        return [each for each in found if each.parameters]

    @cached_property
    def own_words(self) -> frozenset[str]:
        """Return the words in the names of what can be said."""
        return frozenset(word for form in self.forms for word in name_words(form.name))

    @cached_property
    def _fields(self) -> Mapping[tuple[str, int], set[tuple[str, ...]]]:
        """Return by which names of fields a callee's parameters are given: `coat(f.rod, f.ground)`."""
        found: defaultdict[tuple[str, int], set[tuple[str, ...]]] = defaultdict(set)
        for name in [self.program.name, *self.registry.called_by(self.program.name)]:
            row = self.registry[name]
            for statement in row.body if isinstance(row, Program) else ():
                call = innermost(statement)
                for number, term in enumerate(call.arguments):
                    if isinstance(term, nodes.Field):
                        found[call.callee, number].add(tuple(name_words(term.name)))
        return found

    @cached_property
    def nouns(self) -> frozenset[str]:
        """Return words for what is said, that name nothing by themselves: of parameters and programs."""
        named = [each.name for form in self.forms for each in form.parameters]
        named += [each.type for each in self.program.parameters if each.is_list]
        return frozenset(word for name in (*named, self.program.name) for word in name_words(name))

    @cached_property
    def verbs(self) -> frozenset[str]:
        """Return the stems of the words that declarations use, and of those that say much the same."""
        return with_synonyms(frozenset(verb for form in self.forms for verb in form.verbs))

    @cached_property
    def _sharers(self) -> Counter[str]:
        """Return how many declarations use each word."""
        return Counter(verb for form in self.forms for verb in form.verbs)

    def meant_by(
        self, clause: Clause, as_element: bool = False, relates_otherwise: bool = False
    ) -> Iterator[Scored]:
        """Yield what a clause may mean; where as many things as places are listed, each goes with its own.

        Args:
            as_element: it tells the fields of one element.
            relates_otherwise: what it says of how things are related is not what an element says.
        """
        pairs = [] if as_element else respective(clause)
        for form in self.forms:
            if (as_element and not form.is_element) or (relates_otherwise and form.is_element):
                continue
            if not pairs:
                for each in (clause, *self._one_by_one(clause, form)):
                    yield from self._matched(each, form, as_element)
                continue
            likeliest = [max(self._matched(each, form), default=None, key=itemgetter(0)) for each in pairs]
            if all(each is not None for each in likeliest):
                score = sum(each[0] for each in likeliest if each) / len(likeliest)
                yield score, tuple(said for each in likeliest if each for said in each[1])

    def _one_by_one(self, clause: Clause, form: Form) -> Iterator[Clause]:
        """Yield a clause in which several things named together are in as many places of a declaration."""
        for each in clause.mentions:
            if not each.is_many or len(each.senses) > 1 or each not in [part for _, part in clause.parts]:
                continue
            places = [
                n for n, p in enumerate(form.parameters) if self._fitting(each.senses[0], p) is not None
            ]
            if len(places) == len(each.senses[0].values) > 1:
                yield with_each(clause, each)

    def whole_elements(self, mentions: Sequence[Mention]) -> Iterator[Scored]:
        """Yield the elements of three fields or more of which noun phrases name all, and nothing else.

        Of several elements, each is told before the next one; the first noun phrase may belong to all.
        """
        if any(each.is_many for each in mentions):
            return
        for form in self.forms:
            size = len(form.parameters)
            if not form.is_element or size < LONG:
                continue
            for groups in _groups(mentions, size):
                yield from self._all_whole(groups, form)

    def _all_whole(self, groups: Sequence[Sequence[Mention]], form: Form) -> Iterator[Scored]:
        """Yield what groups of noun phrases say, each of a whole element."""
        found: list[list[Scored]] = []
        for group in groups:
            matched = self._matched(Clause((), frozenset(), tuple(group)), form, as_element=True)
            found.append([each for each in matched if None not in each[1][0].arguments])
            if not found[-1]:
                return
        if len(groups) == 1:
            yield from found[0]
            return
        likeliest = [max(each, key=itemgetter(0)) for each in found]
        score = sum(score for score, _ in likeliest) / len(likeliest)
        yield score, tuple(said for _, meant in likeliest for said in meant)

    def _matched(self, clause: Clause, form: Form, as_element: bool = False) -> Iterator[Scored]:
        """Yield the ways in which a clause says what a declaration does, each with its score."""
        shared = clause.verbs & form.verbs
        spoken = max((VERB / (self._sharers[each] if each in COMMON else 1) for each in shared), default=0.0)
        if not shared and not with_synonyms(clause.verbs).isdisjoint(form.verbs):
            spoken = SYNONYM
        if form.is_element:
            named = [each for each in clause.mentions if not self._is_only_a_kind(each, form)]
            if len(named) < 2 or (clause.is_firm and not as_element):
                return
            clause = replace(clause, parts=tuple((Role.OBJECT, each) for each in named))
        if not spoken and len(clause.parts) == 1 and clause.verbs - COMMON - ATTENTION:
            return  # of one thing alone, the verb tells what becomes of it
        for wording in form.wordings:
            yield from self._worded(clause, form, wording, spoken)

    def _is_only_a_kind(self, mention: Mention, form: Form) -> bool:
        """Return whether a noun phrase is a kind of object that no field takes: "the pipes from 20 mm"."""
        is_certain = len(mention.senses) == 1 and len(mention.senses[0].values) == 1
        return not is_certain and not any(self._fits(mention, field) for field in form.parameters)

    def _is_told_by_types(self, clause: Clause, form: Form) -> bool:
        """Return whether the noun phrases fit the parameters in one way alone."""
        fits = [
            {
                n
                for n, p in enumerate(form.parameters)
                if any(self._fitting(each, p) for each in mention.senses)
            }
            for _, mention in clause.parts
        ]
        if len(fits) > len(form.parameters):
            return False
        ways = permutations(range(len(form.parameters)), len(fits))
        return sum(all(n in fit for n, fit in zip(way, fits, strict=True)) for way in ways) == 1

    def _worded(self, clause: Clause, form: Form, wording: Wording, spoken: float) -> Iterator[Scored]:
        """Yield the ways to put a clause's noun phrases in the places of one wording."""
        is_told = not form.is_element and not clause.is_firm and self._is_told_by_types(clause, form)
        ease = EASE if is_told else 1.0

        def bind(
            at: int, taken: tuple[tuple[int, Sense, Mention], ...], score: float
        ) -> Iterator[tuple[float, dict[int, Sense]]]:
            if score < UNDERSTOOD:
                return
            if at == len(clause.parts):
                named = {number: sense for number, sense, _ in taken}
                if len(named) > form.is_element and not (form.is_element and self._is_untold(form, taken)):
                    open_ones = len(form.parameters) - len(named)
                    yield score + OPEN * open_ones, named
                return
            role, mention = clause.parts[at]
            for number, parameter in enumerate(form.parameters):
                if any(number == other for other, *_ in taken):
                    continue
                cost = 0.0 if form.is_element else self._cost(role, wording[number], parameter)
                cost *= ease if cost > AT_ODDS else 1.0
                cost += self._by_label(form, number, mention)
                for sense in mention.senses:
                    fitting = self._fitting(sense, parameter)
                    if fitting is not None:
                        before = (
                            other
                            for other, _, than in taken
                            if self._told_by_order_alone(form, number, other)
                            or (
                                (than, mention) in clause.listed
                                and self._may_be_taken_for(parameter, form.parameters[other])
                            )
                        )
                        turned = sum(number < other for other in before)
                        after = score + cost + sense.weight * 0.3 + TURNED * turned
                        yield from bind(at + 1, (*taken, (number, fitting, mention)), after)

        for score, named in bind(0, (), clause.weight + ELEMENT * form.is_element):
            if score < UNDERSTOOD:
                continue
            places = [named[n].values if n in named else (None,) for n in range(len(form.parameters))]
            if _scatters(places, wording):
                continue
            if self._moves_what_is_fixed(form, wording, places):
                continue
            weight = sum(sense.weight for sense in named.values()) * 0.7
            meant = tuple(Said(form.name, values, form.is_fact) for values in _together(places))
            twice = any(_repeats(each.arguments) for each in meant)
            if len(meant) <= MOST:
                yield score + spoken + weight + TWICE * twice, meant

    def _by_label(self, form: Form, number: int, mention: Mention) -> float:
        """Return how a noun phrase that says which parameter it is speaks for one: "ground white"."""
        if not mention.label:
            return 0.0
        labelled = [mention.label in self._labels(form, each) for each in range(len(form.parameters))]
        return NAMED if labelled[number] else AT_ODDS if any(labelled) else 0.0

    def _labels(self, form: Form, number: int) -> set[tuple[str, ...]]:
        parameter = form.parameters[number]
        own = {tuple(name_words(parameter.name)), tuple(name_words(parameter.type))}
        return own | self._fields.get((form.name, number), set())

    def _is_untold(self, form: Form, taken: Sequence[tuple[int, Sense, Mention]]) -> bool:
        """Return whether neither types nor names tell which field of an element something is."""
        named = {number for number, _, mention in taken if mention.label in self._labels(form, number)}
        bound = {number: mention for number, _, mention in taken}
        return any(
            other not in {number, *named}
            and self._may_be_taken_for(each, parameter)
            and self._fits(bound[number], each)
            and (other not in bound or self._fits(bound[other], parameter))
            for number, parameter in enumerate(form.parameters)
            if number in bound and number not in named and parameter.type in self.registry.parents
            for other, each in enumerate(form.parameters)
        )

    def _fits(self, mention: Mention, parameter: Parameter) -> bool:
        return any(self._fitting(each, parameter) is not None for each in mention.senses)

    def _may_be_taken_for(self, one: Parameter, other: Parameter) -> bool:
        """Return whether something may be in the place of either of two parameters."""
        if one.type not in self.registry.parents:
            return one.type == other.type
        is_a = self.registry.is_a
        return other.type in self.registry.parents and (
            is_a(one.type, other.type) or is_a(other.type, one.type)
        )

    def _moves_what_is_fixed(
        self, form: Form, wording: Wording, places: Sequence[tuple[str | float | None, ...]]
    ) -> bool:
        """Return whether what never moves would get to what does: "the guest takes the seat"."""
        fixed = [bool(each) and all(value in self._fixed for value in each) for each in places]
        moved = [
            is_so and self._may_move(parameter)
            for role, is_so, parameter in zip(wording, fixed, form.parameters, strict=True)
            if role is Role.THEME
        ]
        goals = [
            not is_so and values != (None,) and parameter.type in self.registry.parents
            for role, is_so, values, parameter in zip(wording, fixed, places, form.parameters, strict=True)
            if role in GOALS
        ]
        return any(moved) and any(goals)

    def _may_move(self, parameter: Parameter) -> bool:
        """Return whether a parameter takes anything that moves."""
        is_a = self.registry.is_a
        return any(is_a(kind, parameter.type) for name, kind in self.types.items() if name not in self._fixed)

    def _told_by_order_alone(self, form: Form, one: int, other: int) -> bool:
        """Return whether only the order of mention can tell two parameters apart."""
        a, b = form.parameters[one], form.parameters[other]
        return a.type not in self.registry.parents and a.type == b.type

    def _cost(self, role: Role, wanted: Role | None, parameter: Parameter) -> float:
        """Return how badly a role fits a parameter; types alone tell members and numbers."""
        if parameter.type not in self.registry.parents:
            return 0.0
        return UNWORDED if wanted is None else _distance(role, wanted)

    def _fitting(self, sense: Sense, parameter: Parameter) -> Sense | None:
        """Return the part of what a noun phrase stands for that a parameter takes."""
        if sense.is_number:
            low, high = bounds(parameter)
            is_within = parameter.low is None or low <= float(sense.values[0]) <= high
            return sense if sense.measures == parameter.type and is_within else None
        if parameter.type in self.registry.enums:
            fits = tuple(v for v in sense.values if v in self.registry.enums[parameter.type])
        elif parameter.type in self.registry.parents:
            fits = tuple(
                v
                for v in sense.values
                if isinstance(v, str)
                and v in self.types
                and self.registry.is_a(self.types[v], parameter.type)
            )
        else:
            return None
        if not fits or (len(fits) < len(sense.values) and len(sense.values) == 1):
            return None
        return Sense(fits, sense.weight)


def _groups(mentions: Sequence[Mention], size: int) -> Iterator[list[Sequence[Mention]]]:
    """Yield the ways to divide noun phrases among elements of as many fields."""
    count = len(mentions)
    if count and count % size == 0:
        yield [mentions[at : at + size] for at in range(0, count, size)]
    if count > size and (count - 1) % (size - 1) == 0:
        rest = range(1, count, size - 1)
        yield [[mentions[0], *mentions[at : at + size - 1]] for at in rest]


def _distance(role: Role, wanted: Role) -> float:
    """Return how unlike two roles are, as the logarithm of a probability."""
    if role is wanted:
        return 0.0
    pair = {role, wanted}
    if pair & FIRM:
        return -4.0
    if pair <= GOALS:
        return -0.7
    if Role.OBJECT in pair or Role.OF in pair:
        return -1.0
    return -4.0 if Role.THEME in pair else -1.5


def _together(places: Sequence[tuple[str | float | None, ...]]) -> Iterator[tuple[str | float | None, ...]]:
    """Yield the arguments that are meant together: of as many things and places, each goes with its own."""
    counts = [len(each) for each in places if len(each) > 1]
    if len(counts) > 1 and len({*counts}) == 1:
        wide = [each * counts[0] if len(each) == 1 else each for each in places]
        yield from zip(*wide, strict=True)
    else:
        yield from product(*places)


def _repeats(arguments: Sequence[object]) -> bool:
    """Return whether one object or member is named twice."""
    names = [each for each in arguments if isinstance(each, str)]
    return len({*names}) < len(names)


def _scatters(places: Sequence[tuple[str | float | None, ...]], wording: Wording) -> bool:
    """Return whether one thing would go to several places, or several to others of another number."""
    counts = [len(each) for each in places]
    several = [role for role, count in zip(wording, counts, strict=True) if count > 1]
    if len(several) == 1:
        return several[0] in GOALS and len(counts) > 1
    return len({count for count in counts if count > 1}) > 1


def _texts(declared: Program | Api) -> list[str]:
    """Return the wordings of a call: its docstring is the first."""
    return [declared.docstring, *declared.says]
