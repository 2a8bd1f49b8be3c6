"""What it means that an item has arrived: `on` or `in`, and predicates composed of them, up to three deep."""

from __future__ import annotations

from dataclasses import dataclass

from ntp_dsl.soup.draft import Draft
from ntp_dsl.soup.hands import Hand
from ntp_dsl.soup.kinds import Family, Kind

DEEPEST = 3


@dataclass(frozen=True)
class Pair:
    """A predicate or a program of an item and a place, which takes them in one order or the other.

    Where it takes a number as well, that comes last.
    """

    name: str
    place_first: bool = False
    numbered: bool = False

    def __call__(self, item: str, place: str, number: str = "") -> str:
        first, second = (place, item) if self.place_first else (item, place)
        more = f", {number}" if self.numbered else ""
        return f"{self.name}({first}, {second}{more})"


@dataclass(frozen=True)
class Relation:
    """Equivalent predicates between items and places, from the world's to the most composed."""

    levels: tuple[Pair, ...]

    def drawn(self, draft: Draft) -> Pair:
        return draft.pick(self.levels)


def relation(draft: Draft, hand: Hand, items: Family, places: Kind) -> Relation:
    """Declare what it means that an item is at a place."""
    base = "in" if places.form.hollow else "on"
    levels = [Pair(base)]
    if draft.chance(0.3):
        item, place = draft.names.word(), draft.names.word()
        levels = [Pair(draft.predicate(f"{item}: Object, {place}: Place", f" by {base}"))]
    for _ in range(draft.pick((0, 1, 1, 2, DEEPEST))):
        levels.append(_composed(draft, hand, levels[-1], items, places))
    return Relation(tuple(levels))


def ordered(draft: Draft, item: str, item_type: str, place: str, place_type: str) -> tuple[str, bool]:
    """Return the parameters of an item and a place in a random order, and whether the place is first."""
    place_first = draft.chance(0.4)
    parts = [f"{item}: {item_type}", f"{place}: {place_type}"]
    return ", ".join(reversed(parts) if place_first else parts), place_first


def _composed(draft: Draft, hand: Hand, inner: Pair, items: Family, places: Kind) -> Pair:
    """Declare a predicate that holds just where another does, of items that are left to themselves.

    None names `present` or `reachable`: what a program achieves counts as a fact that can be provided.
    """
    item, place, other = (draft.names.word() for _ in range(3))
    parameters, place_first = ordered(draft, item, items.root, place, places.type)
    fact, held = inner(item, place), f"{hand.holding}({item})"
    bodies = [
        fact,
        f"{fact} and not {held}",
        f"({held} or {fact}) and not {held}",
        f"not ({held} or not {fact})",
        f"some {inner(other, place)} for {other} in {items.root} if {other} == {item}",
        f"{fact} and ({hand.empty}(gripper) or not {held})",
    ]
    if places.form.hollow:
        bodies += [f"{fact} or on({item}, {place})", f"{fact} and hollow({place})"]
    else:
        bodies.append(f"{fact} or in({item}, {place})")
    if items.width:
        bodies.append(f"{fact} and {items.width.reading}({item}) < {draft.between(11, 19)} cm + 1 cm")
    return Pair(draft.predicate(parameters, f": {draft.pick(bodies)}"), place_first)
