"""Small changes of a list: where the first guess does not explain a demonstration, one of them may."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from itertools import combinations, permutations, product

from ntp_dsl.core.reading.candidates import Candidate
from ntp_dsl.core.reading.reading import values_in


def changed_lists(chosen: Sequence[Candidate], risen: Sequence[Candidate]) -> Iterator[list[Candidate]]:
    """Yield lists with one element more, less, exchanged or elsewhere, with two exchanged for one, and with
    two of which one has what the other had.
    """
    others = [each for each in risen if each not in chosen]
    for count in (0, 1, 2):
        if count == 2:
            for moved, place in product(chosen, range(len(chosen))):
                kept = [each for each in chosen if each is not moved]
                yield [*kept[:place], moved, *kept[place:]]
        for dropped in combinations(chosen, count):
            kept = [each for each in chosen if each not in dropped]
            if count == 1:
                yield kept
            for more in others:
                place = next((k for k, each in enumerate(kept) if each.rise > more.rise), len(kept))
                yield [*kept[:place], more, *kept[place:]]
                if count == 1:
                    yield [more if each is dropped[0] else each for each in chosen]
    values = {id(each): Counter(values_in(each.element)) for each in (*chosen, *others)}
    for one, other in combinations(chosen, 2):
        both = values[id(one)] + values[id(other)]
        for pair in permutations([each for each in others if values[id(each)] <= both], 2):
            if sum((values[id(each)] for each in pair), Counter[str]()) == both:
                put = {id(one): pair[0], id(other): pair[1]}
                yield [put.get(id(each), each) for each in chosen]
