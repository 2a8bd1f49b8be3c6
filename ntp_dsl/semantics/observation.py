"""An observation: the objects of a scene, their poses and the hand at one moment."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from math import hypot, inf, sqrt
from typing import NamedTuple

from ntp_dsl.semantics.geometry import UNTURNED, Quaternion, Vector, extents_as_it_lies


@dataclass(frozen=True)
class Record:
    """A record of the language at run time, such as a `Placement`."""

    type: str
    fields: tuple[tuple[str, str | float], ...]  # objects, members and numbers [SI]

    def __getitem__(self, name: str) -> str | float:
        for field_name, value in self.fields:
            if field_name == name:
                return value
        raise KeyError(name)

    def __str__(self) -> str:
        return f"({', '.join(f'{v:g}' if isinstance(v, float) else v for _, v in self.fields)})"


Argument = str | float | Record | tuple[Record | str, ...]
TOO_WIDE = 0.8  # for anything but a table, which never moves and whose top is at height zero [m]
IN_HAND = 0.035  # from the tool's point to where an object is held [m]
ROOMY = 0.12  # a fixed object wider than this has room for several objects [m]


BIN_WALL, BOWL_WALL, BOWL_FLOOR = 0.005, 0.004, 0.014  # thicknesses [m]


def without_lists(arguments: tuple[Argument, ...]) -> tuple[str | float, ...]:
    """Return the objects, members and numbers among arguments, records replaced by their fields."""
    flat: list[str | float] = []
    for argument in arguments:
        if isinstance(argument, Record):
            flat += [value for _, value in argument.fields]
        elif not isinstance(argument, tuple):
            flat.append(argument)
    return tuple(flat)


class DeclaredFact(NamedTuple):
    """A ground fact that a scene or a world declares of objects, such as that a drawer is open."""

    predicate: str
    arguments: tuple[str, ...]

    def __str__(self) -> str:
        return f"{self.predicate}({', '.join(self.arguments)})"


class Cavity(NamedTuple):
    """A hollow: half of its extent along x and y, and its floor above the object's bottom [m]."""

    half_x: float
    half_y: float
    floor: float


@dataclass(frozen=True)
class SceneObject:
    """An object of the scene, which arguments may refer to. `size` is its full extent [m].

    `traits` are properties that a task's scene gives it, such as a category or a colour: reading -> value.
    """

    name: str
    type: str
    size: Vector
    shape: str = "box"
    file: str = ""  # of a mesh or URDF
    fixed: bool = False  # never moves, although a hand could take it
    traits: tuple[tuple[str, str | float], ...] = ()

    @property
    def movable(self) -> bool:
        return not self.fixed and self.size[0] <= TOO_WIDE

    @property
    def roomy(self) -> bool:
        """Return whether it is a surface with room for several objects, such as a table or a tray."""
        return not self.movable and min(self.size[:2]) > ROOMY

    @property
    def flat(self) -> bool:
        """Return whether it is roomy and no bin, so that a place on it has to be chosen."""
        return self.roomy and self.cavity is None

    @property
    def cavity(self) -> Cavity | None:
        """Return the hollow of a bin or bowl."""
        if self.shape == "bin":
            return Cavity(self.size[0] / 2 - BIN_WALL, self.size[1] / 2 - BIN_WALL, BIN_WALL)
        if self.shape == "bowl":  # a round hollow holds what fits its inscribed square
            inner = (self.size[0] / 2 - BOWL_WALL) / sqrt(2)
            return Cavity(inner, inner, BOWL_FLOOR)
        return None

    @property
    def reach(self) -> float:
        """Return the radius of the upright cylinder that encloses it [m]."""
        is_round = self.shape in ("cylinder", "bowl")
        return self.size[0] / 2 if is_round else hypot(*self.size[:2]) / 2


@dataclass(frozen=True)
class Observation:
    """A snapshot of the scene. Lost objects have no position."""

    objects: tuple[SceneObject, ...]
    positions: Mapping[str, Vector]  # centres, world frame [m]
    gripper: Vector  # the point between the fingertips, world frame [m]
    closed: bool
    unreachable: frozenset[str] = frozenset()
    orientations: Mapping[str, Quaternion] = field(default_factory=dict)  # object to world; else unturned
    deviations: Mapping[str, float] = field(default_factory=dict)  # of positions, standard [m]; else 0
    facts: frozenset[DeclaredFact] = frozenset()  # that hold and are not geometry
    forced: Mapping[DeclaredFact, bool] = field(default_factory=dict)  # whether they hold, in any case

    @cached_property
    def by_name(self) -> Mapping[str, SceneObject]:
        """Return each object as it lies: one that is turned or has tipped over has its extents exchanged."""
        return {obj.name: self._lying(obj) for obj in self.objects}

    def orientation(self, name: str) -> Quaternion:
        """Return an object's orientation in the world frame; `UNTURNED` where it is not given."""
        return self.orientations.get(name, UNTURNED)

    def _lying(self, obj: SceneObject) -> SceneObject:
        """Return an object as it lies; hollow objects and trays count as upright."""
        turn = self.orientations.get(obj.name)
        if turn is None or obj.roomy or obj.cavity is not None:
            return obj
        size = extents_as_it_lies(obj.size, turn)
        return obj if size == obj.size else replace(obj, size=size)

    def facts_about(self, names: Collection[object]) -> list[str]:
        """Return the facts of the state that hold of some objects, as text."""
        about = [each for each in self.facts if not set(names).isdisjoint(each.arguments)]
        return sorted(map(str, about))

    @cached_property
    def held(self) -> str | None:
        """Return the object between the closed fingers, the nearest, or None."""
        if not self.closed:
            return None
        near = [
            (distance, obj.name)
            for obj in self.by_name.values()
            if obj.movable and obj.name in self.positions
            if (distance := self._from_grip(obj)) < IN_HAND
        ]
        return min(near)[1] if near else None

    def _from_grip(self, obj: SceneObject) -> float:
        """Return the distance from the tool to an object's grasp point: its middle, or a bowl's rim [m].

        A tall object is held near its top. All of a rim is equally far from the bowl's middle, however the
        bowl hangs; a hand over the middle is not holding the bowl.
        """
        (gx, gy, gz), (x, y, z) = self.gripper, self.positions[obj.name]
        aside = hypot(x - gx, y - gy)
        if obj.cavity is None:
            return max(aside, abs(z - gz) - max(0.0, obj.size[2] / 2 - IN_HAND))
        if aside < obj.size[0] / 4:
            return inf
        return abs(hypot(aside, z - gz) - hypot(obj.size[0], obj.size[2]) / 2)

    def permuted(self, order: tuple[int, ...]) -> Observation:
        """Return the same moment with its objects listed in another order."""
        return replace(self, objects=tuple(self.objects[index] for index in order))
