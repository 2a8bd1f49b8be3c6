"""Of elements that explain as much, the likeliest; the others are kept as doubts."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import partial

from ntp_dsl.core.reading.candidates import Candidate, Element, ListContract
from ntp_dsl.core.reading.moments import Moments
from ntp_dsl.core.reading.reading import Doubt, Reading, values_in
from ntp_dsl.semantics.observation import without_lists
from ntp_dsl.semantics.state import State

SAME = 1.1  # ratio of likelihoods up to which an element is kept rather than replaced by another
UNLIKELY = 0.02  # probability below which others are not reported
RIVALS = 24  # others that are tried in an element's place


class Weighing:
    """Weighs the elements of lists against others.

    Args:
        contracts: of each list, by its parameter.
        told: reads a demonstration with given elements.
    """

    def __init__(
        self,
        contracts: Mapping[str, ListContract],
        moments: Moments,
        told: Callable[[Sequence[Candidate]], Reading],
    ) -> None:
        self._contracts, self._moments, self._told = contracts, moments, told

    def weighed(
        self, chosen: list[Candidate], found: Sequence[Candidate]
    ) -> tuple[list[Candidate], tuple[Doubt, ...]]:
        """Replace elements by likelier ones, and return them with the doubts that remain."""
        doubts: list[Doubt] = []
        for place, own in enumerate(chosen):
            rivals = self._rivals(chosen, place, found)
            total = sum(rivals.values())
            if not total:
                continue
            best = max(rivals, key=rivals.__getitem__)
            taken = best if rivals[best] > SAME * rivals.get(own, 0.0) else own
            chosen = [*chosen[:place], taken, *chosen[place + 1 :]]
            others = [(each, fit / total) for each, fit in rivals.items() if each is not taken]
            others = sorted((each for each in others if each[1] > UNLIKELY), key=lambda each: -each[1])
            if not others:
                continue
            calls = self._calls(chosen)
            share = rivals[taken] / total
            doubtful: list[tuple[Element, float]] = []
            for other, chance in others:
                if self._calls([*chosen[:place], other, *chosen[place + 1 :]]) == calls:
                    share += chance  # nothing that is done depends on which of the two is meant
                else:
                    doubtful.append((other.element, chance))
            if doubtful:
                number = [each for each in chosen if each.parameter == own.parameter].index(taken)
                frame = self._moments.phases[own.rise][0]
                doubts.append(Doubt(own.parameter, number, frame, taken.element, share, tuple(doubtful)))
        return chosen, tuple(doubts)

    def _is_the_same(self, one: Candidate, other: Candidate) -> bool:
        """Return whether two elements name the same objects, in any order, and hold in the same states.

        Members do not count: one that the contract does not mention is no field of the demonstration.
        """
        objects = self._moments.ends[0].observation.by_name
        named = [sorted(name for name in values_in(e.element) if name in objects) for e in (one, other)]
        if named[0] != named[1]:
            return False
        holds = self._contracts[one.parameter].holds

        def agree(states: Iterable[State]) -> bool:
            return all(holds(one.element, each) == holds(other.element, each) for each in states)

        moved = self._moments.ends[one.rise - 1].observation.held
        return agree(self._moments.ends) and (
            moved is None or agree(self._moments.beside(self._moments.phases[one.rise][1] - 1, moved).states)
        )

    def _calls(self, chosen: Sequence[Candidate]) -> list[tuple[str, tuple[str | float, ...]]]:
        """Return the calls that the demonstration shows with some elements."""
        calls = self._told(chosen).call.walk()
        return [(each.name, without_lists(each.arguments)) for each in calls]

    def _rivals(
        self, chosen: Sequence[Candidate], place: int, found: Sequence[Candidate]
    ) -> dict[Candidate, float]:
        """Return an element and those that explain as much in its place, each with its likelihood.

        They come true together. Elements that differ in numbers only are one: numbers are in the middle of
        what fits. Nothing is returned where there are no others.
        """
        own = chosen[place]
        if not own.rise:
            return {}
        by_values = {
            tuple(values_in(each.element)): each
            for each in reversed(found)
            if each.rise == own.rise and each.parameter == own.parameter and each not in chosen
        }
        by_values.pop(tuple(values_in(own.element)), None)
        if not by_values:
            return {}
        able = {own: self._told(chosen).acts_explained}
        for each in [*by_values.values()][:RIVALS]:
            if any(self._is_the_same(each, other) for other in able):
                continue
            explained = self._told([*chosen[:place], each, *chosen[place + 1 :]]).acts_explained
            if len(explained) >= len(able[own]):
                able[each] = explained
        last = own.rise - 1  # the act by which they come true
        if any(last in explained for explained in able.values()):
            able = {each: explained for each, explained in able.items() if last in explained}
        likely = self._likelihoods([*able])
        return likely if {*likely} - {own} else {}

    def _likelihoods(self, some: Sequence[Candidate]) -> dict[Candidate, float]:
        """Return how likely elements are that come true together: alike where nothing was put down.

        Those are left out that cannot be compared with the first one, which is always there: the middle of
        where an element holds is found for both, or for neither.
        """
        own = some[0]
        before, after = self._moments.ends[own.rise - 1 : own.rise + 1]
        moved = before.observation.held
        contract = self._contracts[own.parameter]
        facts = {each: {*contract.facts(each.element, after)} for each in some}
        alike = [each for each in some if facts[each] == facts[own]]
        if moved is None or moved == after.observation.held or len(alike) == len(some):
            return dict.fromkeys(some, 1.0)
        beside = self._moments.beside(self._moments.phases[own.rise][1] - 1, moved)
        fits = {each: beside.likelihood(partial(contract.holds, each.element)) for each in some}
        known = {each: fit for each, fit in fits.items() if fit is not None}
        if own in known:
            return known
        return dict.fromkeys([each for each in some if each in alike or fits[each] is None], 1.0)
