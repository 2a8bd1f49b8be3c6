"""What a program does besides its goal: loops over objects by a reading, or over a whole group."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from ntp_dsl.soup.deliveries import Buffer, Job, delivery
from ntp_dsl.soup.draft import Draft
from ntp_dsl.soup.hands import Hand
from ntp_dsl.soup.kinds import Family, Form, Kind, family, kind
from ntp_dsl.soup.lists import Part
from ntp_dsl.soup.relations import relation
from ntp_dsl.soup.scenes import Scene

KEY = "errand"


@dataclass(frozen=True)
class Errand:
    """Items that all go to one place, whatever the goal: those of a group, or of one member of a category."""

    items: Family
    places: Kind
    part: Part

    def prepare(self, scene: Scene, draft: Draft) -> dict[str, str]:
        """Add the groups to a scene, and return the list that the part takes, if it takes one."""
        scene.places(self.places, 1)
        group = scene.items(self.items, 1, draft.between(1, 3))
        return {KEY: group} if self.part.list_of else {}


def errand(draft: Draft, hand: Hand, spare: Buffer | None, forms: Sequence[Form]) -> Errand:
    """Declare the items, a place of one of the forms, and the programs that bring the ones to the other."""
    by_reading = draft.chance(0.5)
    items = family(draft, category=by_reading)
    places = kind(draft, draft.pick(forms))
    fact = relation(draft, hand, items, places)
    deliver = delivery(draft, Job(hand, items, places, fact, spare))
    item, place = draft.names.word(), draft.names.word()
    arrived, call = fact.drawn(draft)(item, place), deliver(item, place, "6 cm")
    wanted = ""
    if by_reading:
        assert items.category is not None
        wanted = f" if {items.category.reading}({item}) == {draft.pick(items.category.values)}"

    def promise(group: str, number: str) -> str:
        return f"all {arrived} for {item} in {group or items.root}{wanted} for {place} in {places.type}"

    def statements(group: str, number: str) -> list[str]:
        return [f"for {item} in {group or items.root}{wanted}: for {place} in {places.type}: {call}"]

    list_of = "" if by_reading else items.root
    return Errand(items, places, Part(KEY, list_of, promise, statements))
