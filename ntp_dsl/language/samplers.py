"""The ways in which a task may draw its goals, their knobs, and which settings nothing can meet."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass

from ntp_dsl.language.syntax import Option

Flaw = tuple[str, str]  # the option at fault, and what is wrong with it


@dataclass(frozen=True)
class SamplerKind:
    """A sampler: the record that its goals are lists of, its knobs, and their test."""

    record: str
    options: tuple[str, ...]
    flaws: Callable[[Mapping[str, Option], int], Iterator[Flaw]]


def blocks_needed(placements: int, height: int) -> int:
    """The fewest blocks that so many placements take, in towers no higher than `height`."""
    return placements + -(-placements // (height - 1))


def _tower_flaws(options: Mapping[str, Option], blocks: int) -> Iterator[Flaw]:
    """`height` is the highest tower's: height=4 means that one has four blocks and none more."""
    placements, height = options["placements"], options["height"]
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


SAMPLERS: Mapping[str, SamplerKind] = {
    "towers": SamplerKind("Placement", ("placements", "height"), _tower_flaws),
}
