"""The types of a random library: items that the gripper can take, and places that they go to."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum, auto

from ntp_dsl.soup.draft import Draft


class Form(Enum):
    """What a place is like."""

    PAD = auto()  # flat, for one item
    TRAY = auto()  # flat, for several
    BIN = auto()
    BOWL = auto()  # hollow, for one item
    ITEM = auto()  # another item, which can be moved itself

    @property
    def hollow(self) -> bool:
        """Return whether items go into it."""
        return self in (Form.BIN, Form.BOWL)

    @property
    def large(self) -> bool:
        """Return whether it takes a side of the table."""
        return self in (Form.TRAY, Form.BIN, Form.BOWL)

    @property
    def shared(self) -> bool:
        """Return whether it takes several items."""
        return self in (Form.TRAY, Form.BIN)


@dataclass(frozen=True)
class Trait:
    """A reading that the scene gives: a member of an enumeration, or a length."""

    reading: str
    type: str
    values: tuple[str, ...]

    def test(self, draft: Draft, item: str) -> tuple[str, str]:
        """Return a condition on an item's reading, and the opposite."""
        value = f"{self.reading}({item})"
        if self.type != "length":
            member = draft.pick(self.values)
            return f"{value} == {member}", f"{value} != {member}"
        limit = f"{draft.between(3, 9)} cm"
        return f"{value} <= {limit}", f"{value} > {limit}"


@dataclass(frozen=True)
class Family:
    """A type of items with its subtypes, and what the scene tells of them."""

    root: str
    leaves: tuple[str, ...]
    category: Trait | None = None
    width: Trait | None = None

    @property
    def traits(self) -> tuple[Trait, ...]:
        return tuple(trait for trait in (self.category, self.width) if trait)


@dataclass(frozen=True)
class Kind:
    """A type of places of one form."""

    type: str
    form: Form


def family(draft: Draft, category: bool = False, width: bool = False) -> Family:
    """Declare items: a type, perhaps between others, and readings of it where asked for, or by chance."""
    parent = "Movable"
    if draft.chance(0.4):
        parent = draft.type(parent)
    root = draft.type(parent)
    leaves = tuple(draft.type(root) for _ in range(draft.pick((0, 0, 1, 2)))) or (root,)
    return Family(
        root,
        leaves,
        _category(draft, root) if category or draft.chance(0.3) else None,
        _width(draft, root) if width or draft.chance(0.3) else None,
    )


def _category(draft: Draft, root: str) -> Trait:
    name, members = draft.names.type(), tuple(draft.names.word() for _ in range(draft.between(2, 4)))
    draft.declare(f"enum {name}: {', '.join(members)}")
    return Trait(draft.predicate(f"{draft.names.word()}: {root}", f" -> {name}"), name, members)


def _width(draft: Draft, root: str) -> Trait:
    sizes = sorted(draft.shuffled(range(2, 11))[: draft.between(2, 4)])
    reading = draft.predicate(f"{draft.names.word()}: {root}", " -> length")
    return Trait(reading, "length", tuple(f"{size} cm" for size in sizes))


def kind(draft: Draft, form: Form) -> Kind:
    """Declare places of a form."""
    parent = draft.type("Place") if draft.chance(0.3) else "Place"
    return Kind(draft.type(parent), form)


def item_shape(draft: Draft) -> str:
    """Return a shape that the gripper can take, and that stands on another."""
    across = draft.between(6, 11) / 2
    height = draft.size(2.5, min(5.0, across + 1))
    match draft.pick(("cube", "box", "cylinder")):
        case "cube":
            return f"cube({across:g} cm)"
        case "box":
            return f"box({across:g} cm, {draft.size(3, 5.5)}, {height})"
        case _:
            return f"cylinder({across:g} cm, {height})"


def place_shape(draft: Draft, form: Form) -> str:
    """Return a shape of a place: a pad is too narrow for two items, a tray has room for several."""
    match form:
        case Form.TRAY:
            return f"box({draft.size(19, 22)}, {draft.size(19, 24)}, {draft.size(0.5, 2)})"
        case Form.BIN:
            return f"bin({draft.size(18, 22)}, {draft.size(18, 22)}, {draft.size(6, 9)})"
        case Form.BOWL:
            return f"bowl({draft.size(14, 17)}, {draft.size(5, 7)})"
        case _:
            across = draft.size(6.5, 10)
            if draft.chance(0.3):
                return f"cylinder({across}, {draft.size(0.5, 2)})"
            return f"box({across}, {draft.size(6.5, 10)}, {draft.size(0.5, 2)})"
