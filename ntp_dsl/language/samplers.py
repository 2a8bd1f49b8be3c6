"""The ways in which a task may draw its goals, their knobs, and which settings nothing can meet.

Each goal is three choices: its length, its topology (what the elements are to one another: which towers,
who shares a support) and its semantics (which things take which part). The first is a sampler's own knob;
`topology=0..9` and `semantics=0..99` say which of the possible choices may be made, so that a task can be
trained on some and tested on others.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass

from ntp_dsl.language.syntax import Option

Flaw = tuple[str, str]  # the option at fault, or nothing for the sampler itself; and what is wrong
VARIED = ("topology", "semantics")


@dataclass(frozen=True)
class SamplerKind:
    """A sampler: what it draws from, the knob that is its length, its others, and their test.

    `sources` says what each argument stands for; the last may be given several times where
    `many_sources` is set. `flaws` takes the knobs and how many things each source has at least.
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
    """The fewest blocks that so many placements take, in towers no higher than `height`."""
    return placements + -(-placements // (height - 1))


def _tower_flaws(options: Mapping[str, Option], counts: Sequence[int]) -> Iterator[Flaw]:
    """`height` is the highest tower's: height=4 means that one has four blocks and none more."""
    placements, height = options["placements"], options["height"]
    blocks = sum(counts)
    if placements.low < 1:
        yield "placements", "a goal without a placement is empty: nothing would have to be done"
    elif height.low < 2:
        yield "height", "a tower has at least two blocks"
    elif placements.low < height.low - 1:
        need = height.low - 1
        yield "placements", f"a tower of {height.low} takes {need} placements, not {placements.low}"
    elif height.low > blocks:
        yield "height", f"a tower of {height.low} takes as many blocks; the scene has {blocks}"
    elif (need := blocks_needed(placements.high, min(height.high, placements.high + 1))) > blocks:
        yield (
            "placements",
            f"{placements.high} placements in towers of at most {height.high} take {need} blocks;"
            f" the scene has {blocks}",
        )


def _matching_flaws(options: Mapping[str, Option], counts: Sequence[int]) -> Iterator[Flaw]:
    pairs, each = options["pairs"], options.get("each")
    items, supports = counts
    if pairs.low < 1:
        yield "pairs", "a goal without a pair is empty: nothing would have to be done"
    elif pairs.high > items:
        yield "pairs", f"{pairs.high} pairs take as many items; there are {items}"
    elif each is not None and each.low < 1:
        yield "each", "a support that takes nothing is no support"
    elif each is not None and pairs.high > supports * each.high:
        most = supports * each.high
        yield "pairs", f"{supports} supports take {most} items at most, not {pairs.high}"


def _permutation_flaws(options: Mapping[str, Option], counts: Sequence[int]) -> Iterator[Flaw]:
    items, places = counts
    length = options.get("length")
    if length is not None and length.low < 1:
        yield "length", "a goal of no things is empty: nothing would have to be done"
    elif length is not None and length.high > items:
        yield "length", f"so many things are not in the scene; there are {items}"
    elif (length.high if length else items) > places:
        yield "", f"{length.high if length else items} things do not fit on {places} places"


SAMPLERS: Mapping[str, SamplerKind] = {
    "towers": SamplerKind(
        ("things",), "placements", ("placements", "height"), (), _tower_flaws, many_sources=True
    ),
    "matchings": SamplerKind(("items", "supports"), "pairs", ("pairs",), ("each",), _matching_flaws),
    "permutations": SamplerKind(
        ("items", "places"), "length", (), ("length",), _permutation_flaws
    ),
}
