"""What a demonstration says of a program's lists: the fewest elements that explain what the hand does."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial
from itertools import islice, permutations, takewhile
from math import hypot
from typing import TypeVar

from ntp_dsl.core.reading.candidates import Candidate, Element, ListContract, candidates
from ntp_dsl.core.reading.changes import changed_lists
from ntp_dsl.core.reading.explanation import Explanation, Running, root, unmarked
from ntp_dsl.core.reading.likelihood import Offset
from ntp_dsl.core.reading.moments import Act, Moments
from ntp_dsl.core.reading.numbers import ranges_of
from ntp_dsl.core.reading.reading import Doubt, Measure, Reading, Stray, values_in
from ntp_dsl.core.reading.weighing import Weighing
from ntp_dsl.language.registry import Program
from ntp_dsl.policies.expert import Expert
from ntp_dsl.semantics.facts import Fact
from ntp_dsl.semantics.observation import Argument, Record
from ntp_dsl.semantics.predicates import stands_on
from ntp_dsl.semantics.state import State
from ntp_dsl.traces.schema import DemonstratedCall

FEW = 40  # candidates, among which other lists are tried where the first does not explain all
AHEAD = 6  # acts after one that what runs does not explain, by which it is told whether it goes on
TRIES = 300  # of other lists, between two improvements


Longer = Callable[[Sequence[Candidate], Candidate], list[Candidate]]
Uncertain = TypeVar("Uncertain", Doubt, Measure)


class Reader:
    """Reads the lists of one program from a part of a demonstration."""

    def __init__(
        self, expert: Expert, program: Program, given: Mapping[str, Argument], moments: Moments
    ) -> None:
        self.expert, self.program, self.given, self.moments = expert, program, given, moments
        self._explanation = Explanation(expert, moments)
        self._lists = [parameter for parameter in program.parameters if parameter.is_list]
        everything = moments.ends[0].objects
        parents = expert.registry.parents
        self._all = {
            each.name: tuple(everything(each.type)) if each.type in parents else () for each in self._lists
        }
        scope: dict[str, Argument] = {**given, **self._all}
        moved = {each.observation.held or "" for each in moments.ends}
        self._contracts = {
            each.name: ListContract(expert.registry, program, each, scope, moved) for each in self._lists
        }

        self._untold: Mapping[str, tuple[str, ...]] = {}  # lists that no contract tells: all there are

    def read(self) -> Reading:
        for thorough in (False, True):
            found = self._candidates(thorough)
            shown = {each.parameter for each in found}
            self._untold = {name: value for name, value in self._all.items() if name not in shown}
            risen = [each for each in found if each.rise > 0]
            held = [each for each in found if each.rise == 0 and self._is_a_pile(each)]
            chosen = [*held, *self._choose(risen, self._with)]
            reading = self._told(chosen)
            if not reading.is_whole:
                other = [*held, *self._choose(risen, lambda chosen, more: [*chosen, more])]
                chosen = max(chosen, other, key=self._value)
                if len(risen) <= FEW:
                    chosen = self._improved(chosen, risen)
                reading = self._told(chosen)
            if reading.is_whole or not self._has_numbers():
                break
        chosen, reading = self._without_the_idle(chosen, reading)
        chosen, reading = self._with_surprises(chosen, reading, found)
        chosen, reading = self._with_purposes(chosen, reading, found)
        weighed, doubts = Weighing(self._contracts, self.moments, self._told).weighed(chosen, found)
        if weighed != chosen:
            reading = self._told(weighed)
        return self._finished(weighed, reading, doubts, tuple(self._measures(weighed)))

    def place_of(self, stray: Stray) -> tuple[str, int, Offset] | None:
        """Return a stray object, a frame in which it rests, and how far beside that an element would hold.

        Nothing is returned where no place is near enough that it may lie there, as far as can be seen.
        """
        frame = next(end for begin, end in self.moments.phases if begin <= stray.frame < end) - 1
        seen = self.moments.state(frame)
        deviation = seen.observation.deviations.get(stray.item, 0.0)
        if not deviation:
            return None
        known = {*self._naming(stray.item, seen)}
        for offset, state in self.moments.beside(frame, stray.item).nearby(deviation):
            if {*self._naming(stray.item, state)} - known:
                return stray.item, frame, offset
        return None

    def _naming(self, item: str, state: State) -> Iterator[tuple[str, Element]]:
        """Yield the elements that hold in a state and name an object."""
        for parameter in self._lists:
            ranges = ranges_of(self.expert.registry, self.program, parameter)
            for element in self._contracts[parameter.name].elements(state, ranges, thorough=False):
                if item in values_in(element):
                    yield parameter.name, element

    def settled(self, reading: Reading, answers: Mapping[Doubt, Element]) -> Reading:
        """Return a reading in which somebody has said which elements are meant."""
        said = {(doubt.parameter, doubt.number): element for doubt, element in answers.items()}
        chosen = [
            Candidate(parameter.name, said.get((parameter.name, number), element), 0)
            for parameter, value in zip(self.program.parameters, reading.arguments, strict=True)
            if isinstance(value, tuple)
            for number, element in enumerate(value)
        ]
        doubts = tuple(replace(each, answer=answers.get(each, each.answer)) for each in reading.doubts)
        kept = tuple(each for each in reading.measures if (each.parameter, each.number) not in said)
        return self._finished(chosen, self._told(chosen), doubts, kept)

    def agreeing(self, reading: Reading, arguments: Sequence[Argument]) -> Reading:
        """Return the reading with the lists that a caller has read, where they explain as many acts.

        What is in doubt of elements that both have read stays so.
        """
        lists = {
            parameter.name: value
            for parameter, value in zip(self.program.parameters, arguments, strict=True)
            if isinstance(value, tuple)
        }
        pairs = zip(self.program.parameters, reading.arguments, strict=True)
        if lists == {parameter.name: value for parameter, value in pairs if isinstance(value, tuple)}:
            return reading
        chosen = [Candidate(name, element, 0) for name, value in lists.items() for element in value]
        other = self._told(chosen)
        if other.explained < reading.explained:
            return reading
        return self._finished(
            chosen, other, tuple(_within(reading.doubts, lists)), tuple(_within(reading.measures, lists))
        )

    def _finished(
        self,
        chosen: Sequence[Candidate],
        reading: Reading,
        doubts: tuple[Doubt, ...],
        measures: tuple[Measure, ...],
    ) -> Reading:
        strays = tuple(self._strays(chosen, reading.acts_explained))
        return replace(reading, doubts=doubts, measures=measures, strays=strays)

    def _measures(self, chosen: Sequence[Candidate]) -> Iterator[Measure]:
        """Yield how near the numbers are that were read where something was put down."""
        counts: Counter[str] = Counter()
        for each in chosen:
            number = counts[each.parameter]
            counts[each.parameter] += 1
            moved = self.moments.ends[each.rise - 1].observation.held if each.rise else None
            seen = self.moments.ends[each.rise].observation
            names = values_in(each.element)
            deviation = hypot(*(seen.deviations.get(name, 0.0) for name in {*names, moved} if name))
            if moved is None or not deviation or len(names) == _size(each.element):
                continue
            beside = self.moments.beside(self.moments.phases[each.rise][1] - 1, moved)
            holds = partial(self._contracts[each.parameter].holds, each.element)
            yield Measure(each.parameter, number, each.element, beside.certainty(holds, deviation))

    def _strays(self, chosen: Sequence[Candidate], explained: Collection[int]) -> Iterator[Stray]:
        """Yield what was put down last by an act that neither a call nor what an element says explains."""
        held = [each.observation.held for each in self.moments.ends]
        last = {
            item: act
            for act, item, after in zip(self.moments.acts, held[:-1], held[1:], strict=True)
            if item and item != after
        }
        for item, act in last.items():
            if act.number in explained or any(self._is_served(each, item, act) for each in chosen):
                continue
            yield Stray(item, act.frame)

    def _without_the_idle(self, chosen: list[Candidate], reading: Reading) -> tuple[list[Candidate], Reading]:
        """Return the elements without those of objects that others name too, and that explain no act more."""
        for each in [*chosen]:
            others = [other for other in chosen if other is not each]
            named = {value for other in others for value in values_in(other.element)}
            if each.rise and named.issuperset(values_in(each.element)):
                less = self._told(others)
                if less.explained >= reading.explained:
                    chosen, reading = others, less
        return chosen, reading

    def _with_purposes(
        self, chosen: list[Candidate], reading: Reading, found: Sequence[Candidate]
    ) -> tuple[list[Candidate], Reading]:
        """Return the elements, with others for whose sake objects were put down last, though by no call.

        Whoever demonstrates may go about it in another order than the program would.
        """
        acts = {act.frame: act for act in self.moments.acts}
        for stray in [*self._strays(chosen, reading.acts_explained - reading.in_passing)]:
            act = acts[stray.frame]
            for each in found:
                if each.rise <= act.number or each in chosen or not self._is_served(each, stray.item, act):
                    continue
                contract = self._contracts[each.parameter]
                if contract.is_common(each.element, stray.item, self.moments.ends[0]):
                    continue  # it may be so by chance
                more = self._told(self._with(chosen, each))
                if more.explained >= reading.explained:
                    chosen, reading = self._with(chosen, each), more
                    break
        return chosen, reading

    def _is_served(self, candidate: Candidate, item: str, act: Act) -> bool:
        """Return whether an act makes something true of an object that is a part of what an element says."""
        before, after = self.moments.ends[act.number : act.number + 2]
        facts = self._contracts[candidate.parameter].facts(candidate.element, after)
        return any(item in fact.names and after.holds(fact) and not before.holds(fact) for fact in facts)

    def _with_surprises(
        self, chosen: list[Candidate], reading: Reading, found: Sequence[Candidate]
    ) -> tuple[list[Candidate], Reading]:
        """Return the elements, with others that came true by no call's promise, and hardly by chance.

        Where all acts are explained by less, what an element says may come true as if by chance: an object
        that is put down wherever there is room lies just where it belongs.
        """
        for each in found:
            if each.rise == 0 or each in chosen or not self._is_a_surprise(each, chosen, reading.call):
                continue
            more = self._told(self._with(chosen, each))
            if more.explained >= reading.explained:
                chosen, reading = self._with(chosen, each), more
        return chosen, reading

    def _is_a_surprise(
        self, candidate: Candidate, chosen: Sequence[Candidate], root_call: DemonstratedCall
    ) -> bool:
        before, after = self.moments.ends[candidate.rise - 1 : candidate.rise + 1]
        moved = before.observation.held or after.observation.held
        begun = self.moments.state(self.moments.phases[candidate.rise][0])
        contract = self._contracts[candidate.parameter]
        facts = contract.facts(candidate.element, after)
        if not all(map(begun.holds, facts)) and not after.observation.closed:
            moved = None  # the hand itself brought it about, on its way
        if moved is not None and moved not in values_in(candidate.element):
            return False  # it follows from something else that was moved
        if moved and any(moved in values_in(each.element) for each in chosen):
            return False  # an element that is chosen names that object already
        new = {fact for fact in facts if not before.holds(fact)}
        promised = {fact for call in root_call.walk() for fact in self._promised(call, after)}
        if new & promised:
            return False
        return moved is None or not contract.is_common(candidate.element, moved, self.moments.ends[0])

    def _promised(self, call: DemonstratedCall, state: State) -> Sequence[Fact]:
        callee = self.expert.registry[call.name]
        if call.name == self.program.name:
            return ()
        scope = callee.bind(call.arguments)
        return state.literals(callee.achieves, scope)

    def _has_numbers(self) -> bool:
        registry = self.expert.registry
        fields = [field for each in self._lists for field in registry.records.get(each.type, ())]
        return any(registry.is_number(field.type) for field in fields)

    def _candidates(self, thorough: bool) -> list[Candidate]:
        found: list[Candidate] = []
        for parameter in self._lists:
            contract = self._contracts[parameter.name]
            ranges = ranges_of(self.expert.registry, self.program, parameter)
            found += candidates(contract, self.moments.ends, ranges, thorough)
        return sorted(found, key=lambda each: each.rise)

    def _choose(self, risen: Sequence[Candidate], longer: Longer) -> list[Candidate]:
        """Add candidates, one at a time, while they explain acts that nothing chosen explains.

        Args:
            longer: where it puts a candidate among the chosen ones: elements come in the order in which they
                come true as a whole, or else in that in which they begin to explain acts.
        """
        chosen: list[Candidate] = []
        top = self._root(chosen)
        at = 0
        acts = self.moments.acts
        while at < len(acts):
            after = self._after(top, chosen, at)
            if after is not None:
                top, at = after, at + 1
                continue
            best = self._best_addition(chosen, risen, at, longer)
            if best is None:
                at += 1
            else:
                chosen = longer(chosen, best)
                top = self._root(chosen)
        return chosen

    def _improved(self, chosen: list[Candidate], risen: Sequence[Candidate]) -> list[Candidate]:
        """Return a list that explains more, as far as small changes lead to one; of equals the shortest."""
        best, value = chosen, self._value(chosen)
        while True:
            for changed in islice(changed_lists(best, risen), TRIES):
                found = self._value(changed)
                if found > value:
                    best, value = changed, found
                    break
            else:
                return best

    def _value(self, chosen: Sequence[Candidate]) -> tuple[int, int]:
        return self._told(chosen).explained, -len(chosen)

    def _best_addition(
        self, chosen: Sequence[Candidate], risen: Sequence[Candidate], at: int, longer: Longer
    ) -> Candidate | None:
        """Return the candidate that explains an act, and with it most from there on; of equals the first.

        What explains more in a row comes before what explains more in all: an object that is shown to be
        brought to one place may get to another later, by no act of its own, as in a bowl that is stacked.
        """
        able = [
            each
            for each in risen
            if each.rise > at and each not in chosen and self._explains(longer(chosen, each), at)
        ]
        if len(able) <= 1:
            return able[0] if able else None
        return max(able, key=lambda each: self._counts_explained(longer(chosen, each), at))

    def _explains(self, chosen: Sequence[Candidate], at: int) -> bool:
        return self._explanation.step(self._root(chosen), self.moments.acts[at]) is not None

    def _counts_explained(self, chosen: Sequence[Candidate], at: int) -> tuple[int, int]:
        """Return how many acts from one on are explained in a row, and how many in all."""
        top = self._root(chosen)
        explained: list[bool] = []
        for number in range(at, len(self.moments.acts)):
            after = self._after(top, chosen, number)
            top = top if after is None else after
            explained.append(after is not None)
        return len([*takewhile(bool, explained)]), sum(explained)

    def _after(self, top: Running, chosen: Sequence[Candidate], at: int) -> Running | None:
        """Return what runs after an act; None where nothing explains it, or where it is better left out."""
        act = self.moments.acts[at]
        after = self._explanation.step(top, act)
        return after if after is not None else self._after_anew(top, self._root(chosen), at)

    def _after_anew(self, top: Running, anew: Running, at: int) -> Running | None:
        """Return what runs after an act if the program begins anew; None where it does not.

        Where somebody fumbles, the program may seem to begin anew: it does not where what runs explains as
        much of what comes, this act included.
        """
        after = self._explanation.step(anew, self.moments.acts[at])
        if after is None or self._ahead(top, at + 1) >= 1 + self._ahead(after, at + 1):
            return None
        return after

    def _ahead(self, top: Running, at: int) -> int:
        """Return how many of the next acts a running call explains, if it goes on where it does not."""
        top, count = unmarked(top), 0
        for act in self.moments.acts[at : at + AHEAD]:
            after = self._explanation.step(top, act)
            if after is not None:
                top, count = after, count + 1
        return count

    @staticmethod
    def _with(chosen: Sequence[Candidate], more: Candidate) -> list[Candidate]:
        return sorted([*chosen, more], key=lambda each: each.rise)

    def _is_a_pile(self, candidate: Candidate) -> bool:
        """Return whether an element that holds all along is of movable objects, on one another.

        What else holds all along may do so by chance.
        """
        by_name = self.moments.ends[0].observation.by_name
        objects = [by_name[value] for value in values_in(candidate.element) if value in by_name]
        return all(each.movable for each in objects) and any(
            stands_on(self.moments.ends[0].observation, a.name, b.name) for a, b in permutations(objects, 2)
        )

    def _arguments(self, chosen: Sequence[Candidate]) -> tuple[Argument, ...]:
        return tuple(
            tuple(each.element for each in chosen if each.parameter == parameter.name)
            or self._untold.get(parameter.name, ())
            if parameter.is_list
            else self.given[parameter.name]
            for parameter in self.program.parameters
        )

    def _root(self, chosen: Sequence[Candidate], call: DemonstratedCall | None = None) -> Running:
        return root(self.program.name, self._arguments(chosen), call)

    def _told(self, chosen: Sequence[Candidate]) -> Reading:
        """Return the reading, with the calls that the demonstration shows by it."""
        arguments = self._arguments(chosen)
        call = DemonstratedCall(
            name=self.program.name, arguments=arguments, scope=self.moments.scope, done=True
        )
        call.children = []
        top, explained, in_passing = self._root(chosen, call), set[int](), set[int]()
        for at, act in enumerate(self.moments.acts):
            if self._explanation.step(unmarked(top), act) is None:
                if self._after_anew(top, self._root(chosen), at) is None:
                    continue
                top = self._root(chosen, call)
            after = self._explanation.step(top, act)
            assert after is not None, "it was explained just now"
            top = after
            explained.add(act.number)
            item = self.moments.ends[act.number].observation.held
            if item is not None and top.caller is not None and not top.is_about(item):
                in_passing.add(act.number)
        self._explanation.finish(top)
        call.scope, call.done = self.moments.scope, True
        _close(call)
        unshown = tuple(
            f"{name}.{field}"
            for name, contract in self._contracts.items()
            if any(each.parameter == name for each in chosen)
            for field in contract.unmentioned
        )
        missed = tuple(act.frame for act in self.moments.acts if act.number not in explained)
        return Reading(
            arguments,
            call,
            frozenset(explained),
            len(self.moments.acts),
            missed,
            unshown,
            in_passing=frozenset(in_passing),
        )


def _size(element: Element) -> int:
    return len(element.fields) if isinstance(element, Record) else 1


def _close(call: DemonstratedCall) -> None:
    """Let calls of which no return is shown last until the next one begins, or their caller ends."""
    ends = [*(each.scope[0] for each in call.children[1:]), call.scope[1]]
    for child, end in zip(call.children, ends, strict=False):
        if not child.done:
            child.scope = child.scope[0], max(child.scope[1], end)
        _close(child)


def _within(some: Sequence[Uncertain], lists: Mapping[str, tuple[Argument, ...]]) -> Iterator[Uncertain]:
    """Yield what is uncertain of elements that are in lists, with their numbers there."""
    for each in some:
        elements = lists.get(each.parameter, ())
        if each.element in elements:
            yield replace(each, number=elements.index(each.element))
