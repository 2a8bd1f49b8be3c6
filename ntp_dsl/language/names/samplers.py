"""The samplers from which a task may draw its goals, their options, and which settings are impossible.

Each goal is three choices: its length, its topology (how the elements relate: which towers, what shares a
support) and its semantics (which objects take which part). The first is an option of the sampler;
`topology=0..9` and `semantics=0..99` say which of the possible choices may be made, so that a task can be
trained on some and tested on others.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass

from ntp_dsl.language.syntax.nodes import Option

Range = tuple[int, int]
# The option at fault, or "" for the sampler itself; what is wrong; and the nearest range that is possible.
Flaw = tuple[str, str, Range | None]
VARIED = ("topology", "semantics")


@dataclass(frozen=True)
class SamplerKind:
    """A sampler: what it draws from, the option that is its length, its other options, and their test.

    `sources` says what each argument is; the last may be given several times where `many_sources` is set.
    `flaws` takes the options and how many objects each source has at least.
    """

    sources: tuple[str, ...]
    length: str
    needed: tuple[str, ...]
    optional: tuple[str, ...]
    flaws: Callable[[Mapping[str, Option], Sequence[int]], Iterator[Flaw]]
    many_sources: bool = False
    record: str = "Placement"  # where the goal does not say `-> list[...]`

    @property
    def options(self) -> tuple[str, ...]:
        return (*self.needed, *self.optional, *VARIED)


def blocks_needed(placements: int, height: int) -> int:
    """Return the fewest blocks that so many placements take, in towers no higher than `height`."""
    return placements + -(-placements // (height - 1))


def _tower_flaws(options: Mapping[str, Option], counts: Sequence[int]) -> Iterator[Flaw]:
    """Yield what is impossible; `height` is the highest tower's: one has four blocks, none has more."""
    placements, height = options["placements"], options["height"]
    blocks = sum(counts)
    if placements.low < 1:
        message = "a goal without a placement is empty: there is nothing to do"
        yield "placements", message, _from(placements, 1)
    elif height.low < 2:
        heights = (
            each
            for each in range(2, blocks + 1)
            if blocks_needed(placements.high, max(each, height.high)) <= blocks
        )
        yield "height", "a tower has at least two blocks", _from(height, next(heights, 2))
    elif height.low > blocks:
        message = f"a tower of {height.low} takes {height.low} blocks; the scene has {blocks}"
        highest = min(blocks, placements.low + 1)
        is_enough = highest > 1 and blocks_needed(placements.high, highest) <= blocks
        yield "height", message, (highest, highest) if is_enough else None
    elif placements.low < height.low - 1:
        need = height.low - 1
        message = f"a tower of {height.low} takes {need} placements, not {placements.low}"
        yield "placements", message, _from(placements, need)
    elif (need := _needed(placements.high, height)) > blocks:
        message = (
            f"{placements.high} placements in towers of at most {height.high} take {need} blocks;"
            f" the scene has {blocks}"
        )
        most = max(each for each in range(blocks) if not each or _needed(each, height) <= blocks)
        yield "placements", message, _up_to(placements, most)


def _needed(placements: int, height: Option) -> int:
    return blocks_needed(placements, min(height.high, placements + 1))


def _from(option: Option, low: int) -> Range:
    return low, max(low, option.high)


def _up_to(option: Option, high: int) -> Range | None:
    """Return None where nothing is possible."""
    return (min(option.low, high), high) if high > 0 else None


def _matching_flaws(options: Mapping[str, Option], counts: Sequence[int]) -> Iterator[Flaw]:
    pairs, each = options["pairs"], options.get("each")
    items, supports = counts
    if pairs.low < 1:
        message = "a goal without a pair is empty: there is nothing to do"
        yield "pairs", message, _from(pairs, 1)
    elif pairs.high > items:
        yield "pairs", f"{pairs.high} pairs take as many items; there are {items}", _up_to(pairs, items)
    elif each is not None and each.low < 1:
        yield "each", "a support takes at least one item", _from(each, 1)
    elif each is not None and pairs.high > supports * each.high:
        most = supports * each.high
        message = f"{supports} supports take {most} items at most, not {pairs.high}"
        yield "pairs", message, _up_to(pairs, most)


def _permutation_flaws(options: Mapping[str, Option], counts: Sequence[int]) -> Iterator[Flaw]:
    items, places = counts
    length = options.get("length")
    if length is not None and length.low < 1:
        message = "a goal of no objects is empty: there is nothing to do"
        yield "length", message, _from(length, 1)
    elif length is not None and length.high > items:
        message = f"the scene has only {items} objects"
        yield "length", message, _up_to(length, items)
    elif (length.high if length else items) > places:
        message = f"{length.high if length else items} objects do not fit on {places} places"
        yield "length" if length else "", message, _up_to(length, places) if length else None


SAMPLERS: Mapping[str, SamplerKind] = {
    "towers": SamplerKind(
        ("things",), "placements", ("placements", "height"), (), _tower_flaws, many_sources=True
    ),
    "matchings": SamplerKind(("items", "supports"), "pairs", ("pairs",), ("each",), _matching_flaws),
    "permutations": SamplerKind(("items", "places"), "length", (), ("length",), _permutation_flaws),
}
