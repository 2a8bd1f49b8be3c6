"""Scenes with room for everything: large places at the sides, the rest in the middle of the table."""

from __future__ import annotations

from ntp_dsl.soup.draft import Draft
from ntp_dsl.soup.kinds import Family, Form, Kind, Trait, item_shape, place_shape

SIDES = ((33, 42), (57, 42), (33, -42), (57, -42))  # of which each has room for one large place [cm]
ANYWHERE = "x(0.32 .. 0.68 m), y(-0.25 .. 0.25 m)"  # for places in the middle


class Scene:
    """The groups of one task; large places take the sides in turn."""

    def __init__(self, draft: Draft) -> None:
        self.draft = draft
        self.rows: list[str] = []
        self._sides = draft.shuffled(SIDES)

    @property
    def free_sides(self) -> int:
        return len(self._sides)

    def places(self, kind: Kind, count: int) -> str:
        """Add places of a kind, and return the name of their group."""
        shape = place_shape(self.draft, kind.form)
        where = self._at(count) if kind.form.large else ANYWHERE
        return self._add(f"{count} {kind.type} on table with {shape}, {where}")

    def items(
        self,
        family: Family,
        low: int,
        high: int,
        start: str = "table",
        leaf: str = "",
        category: tuple[str, ...] = (),
    ) -> str:
        """Add items, and return the name of their group.

        Args:
            start: on what they start, a group or the table.
            category: the members that they take in turn; by default all of the enumeration.
        """
        count = f"{low}..{high}" if high > low else str(low)
        details = [item_shape(self.draft)]
        for trait in family.traits:
            members = category if trait is family.category and category else self._values(trait)
            details.append(f"{trait.reading}({', '.join(members)})")
        kind = leaf or self.draft.pick(family.leaves)
        return self._add(f"{count} {kind} on {start} with {', '.join(details)}")

    def _values(self, trait: Trait) -> list[str]:
        return self.draft.shuffled(trait.values)

    def _at(self, count: int) -> str:
        spots = [self._sides.pop() for _ in range(count)]
        return f"at({', '.join(f'{x} cm, {y} cm' for x, y in spots)})"

    def _add(self, row: str) -> str:
        name = self.draft.names.word()
        self.rows.append(f"{name}: {row}")
        return name


def is_shared(form: Form) -> bool:
    """Return whether a place of a form takes several items."""
    return form in (Form.TRAY, Form.BIN)
