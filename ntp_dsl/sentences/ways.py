"""Ways to understand a run of sentences: which elements they say, and how probable each way is."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from math import log

from ntp_dsl.sentences.consequences import Said
from ntp_dsl.sentences.elements import Elements, Placed, values_of

BEAM = 60  # ways to understand all sentences so far, that are followed
WAYS = 40  # ways to understand one clause, that are followed
MOST_OFFERED = 60  # elements of which one is chosen: of more, another sentence has to tell which
ON_THE_WAY = -2.0  # for what leaves open which element it belongs to, and may belong to the next
AGAINST = -3.0  # for an element that says the reverse of another
ANEW = -1.0  # for an element that nothing before has said
GUESSED = -2.5  # for one of several that may be meant: another clause may say which


@dataclass(frozen=True)
class Way:
    """One way to understand a clause: ground calls and facts, all of which are meant."""

    score: float
    meant: tuple[Said, ...]


@dataclass(frozen=True)
class Path:
    """One way to understand all sentences so far.

    Args:
        chosen: elements, with the sentence that said each first.
        waiting: of what was said on the way to an element, those of which one has to be chosen.
    """

    score: float
    chosen: tuple[tuple[int, Placed], ...] = ()
    waiting: tuple[frozenset[Placed], ...] = ()

    @property
    def is_whole(self) -> bool:
        """Whether an element was chosen for everything that was said."""
        chosen = {placed for _, placed in self.chosen}
        return not any(chosen.isdisjoint(each) for each in self.waiting)


def followed(elements: Elements, paths: Sequence[Path], ways: Sequence[Way], number: int) -> list[Path]:
    """Return the paths that go on with a sentence."""
    options: list[tuple[float, list[list[Placed]]]] = []
    for way in ways:
        found = [elements.saying(said) for said in way.meant]
        if all(found):
            named = [
                [placed for placed in offered if elements.names_all(placed, said)]
                for offered, said in zip(found, way.meant, strict=True)
            ]
            beside = AGAINST * sum(not each for each in named)  # what was named is no part of it
            options.append((way.score + beside, [a or b for a, b in zip(named, found, strict=True)]))
        elif all(elements.go_without_saying(said) for said in way.meant):
            options.append((way.score + ANEW, []))
        if len(options) >= WAYS:
            break
    after: dict[object, Path] = {}
    for path in paths:
        for score, places in options:
            for more in _extended(path, score, places, number):
                before = after.get((more.chosen, more.waiting))
                if before is None or more.score > before.score:
                    after[more.chosen, more.waiting] = more
    return sorted(after.values(), key=lambda each: -each.score)[:BEAM]


def _extended(path: Path, score: float, places: Sequence[Sequence[Placed]], number: int) -> Iterator[Path]:
    """Yield a path with an element for each thing that a sentence means."""
    found = [replace(path, score=path.score + score)]
    for offered in places:
        after = []
        for each in found:
            known = [placed for _, placed in each.chosen if placed in offered]
            if known:
                after.append(each)
                continue
            guess = GUESSED - log(len(offered)) if len(offered) > 1 else 0.0
            for placed in offered if len(offered) <= MOST_OFFERED else ():
                chosen = (*each.chosen, (number, placed))
                against = AGAINST * any(_is_reverse(placed, other) for _, other in each.chosen)
                after.append(Path(each.score + ANEW + guess + against, chosen, each.waiting))
            if len(offered) > 1:  # on the way to what another sentence says
                waiting = (*each.waiting, frozenset(offered))
                after.append(Path(each.score + ON_THE_WAY, each.chosen, waiting))
        found = sorted(after, key=lambda each: -each.score)[:BEAM]
    yield from found


def by_sentence(path: Path) -> dict[tuple[int, int], Placed]:
    """Return the elements of a path by the sentence that said them, and their number there."""
    found: dict[tuple[int, int], Placed] = {}
    counts: dict[int, int] = defaultdict(int)
    for number, placed in path.chosen:
        found[number, counts[number]] = placed
        counts[number] += 1
    return found


def _is_reverse(one: Placed, other: Placed) -> bool:
    """Return whether an element names what another does, the other way round."""
    values = values_of(one[1])
    return one[0] == other[0] and len({*values}) > 1 and values == values_of(other[1])[::-1]
