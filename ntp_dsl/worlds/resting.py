"""How objects rest in the kinematic world: on the table, on each other, in bowls; and when they fall."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from math import hypot

import numpy as np

from ntp_dsl.semantics.containers import container_below, contents, floor_in, top_for
from ntp_dsl.semantics.free_space import FREE_GAP, Region, clearance, rank_places
from ntp_dsl.semantics.geometry import Vector
from ntp_dsl.semantics.observation import SceneObject
from ntp_dsl.worlds.scenes import CUBE

BESIDE = 0.06  # from the edge of an object to where an item that falls off it lands [m]
HEAP = 0.1  # of its height, by which an object lies higher for each one already in the bin
SLIVER = 0.008  # overlap that neither supports an object nor stops its fall [m]


class RestingObjects:
    """Positions, and the rules by which objects come to rest. The world moves the hand."""

    _positions: dict[str, Vector]
    _items: dict[str, SceneObject]  # movable objects
    _solid: dict[str, SceneObject]  # all objects on the table, movable or fixed
    _by_name: Mapping[str, SceneObject]
    _regions: tuple[Region, ...]  # where objects may be put down; nothing falls off others beyond the last
    _held: str | None
    _load: list[str]  # the contents of the held bowl
    _gripper: Vector
    _rng: np.random.Generator
    disturbed: set[str]

    def _fall(self, item: str, x: float, y: float) -> None:
        """Let an item fall onto what is below, or off the edge of what does not support its centre.

        It stays where it is released; off an edge it does not fall farther out of reach.
        """
        released = x, y
        if self._unsteady_edge(item, x, y) is not None:
            self.disturbed.add(item)
        for _ in range(20):
            edge = self._unsteady_edge(item, x, y)
            if edge is None:
                break
            ex, ey, _ = self._positions[edge]
            angle = np.arctan2(y - ey, x - ex) + self._rng.normal(0, 0.3)
            reach = BESIDE + max(self._solid[edge].size[:2]) / 2
            x, y = ex + reach * float(np.cos(angle)), ey + reach * float(np.sin(angle))
            x, y = self._within_reach(x, y, released)
        else:
            x, y = self._clearest_on_table(item)
        self._positions[item] = (x, y, self._resting_height(item, x, y))

    def _within_reach(self, x: float, y: float, start: tuple[float, float]) -> tuple[float, float]:
        """Return the nearest point of the region where objects may be, extended to a starting point."""
        (x0, x1), (y0, y1) = self._regions[-1]
        sx, sy = start
        return min(max(x, min(x0, sx)), max(x1, sx)), min(max(y, min(y0, sy)), max(y1, sy))

    def _resting_height(self, item: str, x: float, y: float) -> float:
        """Return the height of the item's centre on what is below, or on the heap in a container [m]."""
        height = self._items[item].size[2]
        container = self._container_below(item, x, y)
        if container is not None:
            floor = self._positions[container.name][2] + floor_in(container)
            heap = HEAP * height * len([n for n in self._contents(container.name) if n != item])
            return min(floor + height / 2 + heap, self._top(container.name))
        tops = (
            self._positions[name][2] + top_for(self._by_name[name], self._items[item])
            for name in self._below(item, x, y)
        )
        return max(tops, default=0.0) + height / 2

    def _below(self, item: str, x: float, y: float) -> list[str]:
        return [name for name, _ in self._others(item) if self._overlap(item, (x, y), name) > SLIVER]

    def _overlap(self, item: str, place: tuple[float, ...], other: str) -> float:
        """Return the overlap of two objects seen from above, along the axis of least overlap [m]."""
        beside = [(self._positions[other], self._solid[other].size)]
        return -float(clearance(place, self._solid[item].size, beside))

    def _container_below(self, item: str, x: float, y: float) -> SceneObject | None:
        others = ((self._by_name[name], at) for name, at in self._others(item))
        return container_below(self._items[item], x, y, others)

    def _contents(self, container: str) -> list[str]:
        return contents(self._by_name[container], self._items.values(), self._positions)

    def _unsteady_edge(self, item: str, x: float, y: float) -> str | None:
        """Return the topmost object below, or None where the objects of that height support the item."""
        below = self._below(item, x, y)
        if not below or self._container_below(item, x, y) is not None:
            return None
        top = max(self._top(name) for name in below)
        tops = [name for name in below if self._top(name) > top - 0.01]
        return None if self._is_balanced(item, x, y, tops) else tops[0]

    def _is_balanced(self, item: str, x: float, y: float, supports: Iterable[str]) -> bool:
        """Return whether the item's centre lies within the convex hull of its contacts with the supports.

        It does if no half of the plane around the centre is free of the touching parts' corners.
        """
        corners = [corner for name in supports for corner in self._touching(item, x, y, name)]
        if not corners:
            return False
        angles = np.sort([np.arctan2(cy - y, cx - x) for cx, cy in corners])
        return float(np.diff(angles, append=angles[0] + 2 * np.pi).max()) < np.pi

    def _touching(self, item: str, x: float, y: float, other: str) -> list[tuple[float, float]]:
        """Return the corners of the rectangle in which two objects overlap, seen from above, if any."""
        sides = []
        for axis, place in enumerate((x, y)):
            half, its = self._solid[item].size[axis] / 2, self._solid[other].size[axis] / 2
            there = self._positions[other][axis]
            sides.append((max(place - half, there - its), min(place + half, there + its)))
        (x0, x1), (y0, y1) = sides
        return [(cx, cy) for cx in (x0, x1) for cy in (y0, y1)] if x0 < x1 and y0 < y1 else []

    def _drop_unsupported(self) -> None:
        """Let objects fall whose support is gone, the lowest first."""
        standing: list[tuple[str, Vector]] = []
        loose: dict[str, Vector] = {}
        for name, place in sorted(self._others(None), key=lambda each: each[1][2]):
            if name not in self._items or self._carried(name, place, standing):
                standing.append((name, place))
            else:
                loose[name] = self._positions.pop(name)
        for name, (x, y, _) in loose.items():
            self.disturbed.add(name)
            self._fall(name, x, y)

    def _carried(self, item: str, place: Vector, standing: list[tuple[str, Vector]]) -> bool:
        bottom = place[2] - self._items[item].size[2] / 2
        if bottom < 0.005 or self._container_below(item, place[0], place[1]) is not None:
            return True  # on the table, or in a bowl
        below = [name for name, _ in standing if abs(bottom - self._top(name)) < 0.01]
        return self._is_balanced(item, place[0], place[1], below)

    def _clearest_on_table(self, item: str) -> tuple[float, float]:
        """Return where an item is farthest from all others; at the region's border if that is full."""
        others = [(at, self._solid[name].size) for name, at in self._others(item)]
        for region in self._regions:
            places, room = rank_places(region, self._items[item].size, others)
            if room[0] > FREE_GAP:
                break
        x, y = places[0].tolist()
        return x, y

    def _tower_below(self, item: str) -> list[str]:
        """Return the item and the objects below it, from the top down."""
        x, y, z = self._positions[item]
        tower = [
            (pz, name)
            for name, (px, py, pz) in self._others(None)
            if name in self._items and hypot(px - x, py - y) < CUBE / 2 and pz <= z
        ]
        return [name for _, name in sorted(tower, reverse=True)]

    def _others(self, item: str | None) -> Iterator[tuple[str, Vector]]:
        for name in self._solid:
            if name not in (item, self._held, *self._load) and name in self._positions:
                yield name, self._positions[name]

    def _top(self, name: str) -> float:
        return self._positions[name][2] + self._by_name[name].size[2] / 2
