"""Scenes with room for everything: large places at the sides, the rest in the middle of the table."""

from __future__ import annotations

from ntp_dsl.soup.draft import Draft
from ntp_dsl.soup.kinds import Family, Kind, item_shape, place_shape

SIDES = ((33, 1), (57, 1), (33, -1), (57, -1))  # x [cm] and side of spots with room for one large place
ASIDE = (40, 44)  # of such a spot's middle, from the middle of the table [cm]
FEWEST = 8  # objects of a scene; below, `ntp check` would try too often to move the hand to what it holds
ANYWHERE = "x(0.32 .. 0.68 m), y(-0.25 .. 0.25 m)"  # for places in the middle


class Scene:
    """The groups of one task; large places take the sides in turn."""

    def __init__(self, draft: Draft) -> None:
        self.draft = draft
        self.rows: list[str] = []
        self._objects = 0
        self._sides = draft.shuffled(SIDES)

    def places(self, kind: Kind, count: int) -> str:
        """Add places of a kind, and return the name of their group."""
        shape = place_shape(self.draft, kind.form)
        where = self._at(count) if kind.form.large else ANYWHERE
        return self._add(count, f"{count} {kind.type} on table with {shape}, {where}")

    def items(
        self,
        family: Family,
        low: int,
        high: int,
        start: str = "table",
        leaf: str = "",
    ) -> str:
        """Add items, and return the name of their group.

        Args:
            start: on what they start, a group or the table.
            leaf: their type; by default one of the family's.
        """
        count = f"{low}..{high}" if high > low else str(low)
        traits = [f"{each.reading}({', '.join(self.draft.shuffled(each.values))})" for each in family.traits]
        details = [item_shape(self.draft), *traits]
        kind = leaf or self.draft.pick(family.leaves)
        return self._add(low, f"{count} {kind} on {start} with {', '.join(details)}")

    def bystanders(self) -> None:
        """Add blocks that no goal is about, where there are few objects, and sometimes elsewhere."""
        lacking = max(FEWEST - self._objects, int(self.draft.chance(0.1)))
        if lacking > 0:
            self._add(lacking, f"{lacking} Block on table with {item_shape(self.draft)}")

    def _at(self, count: int) -> str:
        spots = [self._sides.pop() for _ in range(count)]
        aside = self.draft.between(*ASIDE)
        return f"at({', '.join(f'{x} cm, {side * aside} cm' for x, side in spots)})"

    def _add(self, objects: int, row: str) -> str:
        self._objects += objects
        name = self.draft.names.word()
        self.rows.append(f"{name}: {row}")
        return name
