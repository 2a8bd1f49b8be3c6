"""Where an object can stand among others: what overlaps, and how high it comes to rest."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass, replace
from math import cos, hypot, sin

import numpy as np
from numpy.typing import NDArray

from ntp_dsl.semantics.containers import floor_in, has_room_for, lies_in, takes, top_for
from ntp_dsl.semantics.geometry import Vector
from ntp_dsl.semantics.observation import BOWL_WALL, TOO_WIDE, SceneObject
from ntp_dsl.worlds.protocol import Scene

EXACT = 1e-9  # below which objects touch [m]
Corners = NDArray[np.float64]  # (4, 2), of an object seen from above, world frame [m]


@dataclass(frozen=True)
class Standing:
    """Objects and the places of those that have one; places are added as a scene is built."""

    by_name: Mapping[str, SceneObject]
    positions: dict[str, Vector]

    def on(self, below: str, item: str, x: float, y: float) -> Vector:
        """Return an item's place on or in an object, at a point seen from above."""
        obj = self.by_name[item]
        return x, y, self.positions[below][2] + resting_height(self.by_name[below], obj) + obj.size[2] / 2

    def top(self, name: str) -> Vector:
        """Return the middle of an object's upper face."""
        x, y, z = self.positions[name]
        return x, y, z + self.by_name[name].size[2] / 2

    def is_free(self, item: str, place: Vector, gap: float = 0.0, beside: float = 0.0) -> bool:
        """Return whether an item at a place overlaps no other, and keeps a gap to all at its height.

        Args:
            beside: the gap to what lies in the same container [m].
        """
        obj = self.by_name[item]
        for name, at in self.positions.items():
            other = self.by_name[name]
            if name == item or other.size[0] > TOO_WIDE:
                continue
            room = gap_from_above(obj, place, other, at)
            if room >= max(gap, beside) - EXACT or not share_height(obj, place, other, at):
                continue
            if contained(obj, place, other, at):
                continue
            if room < (beside if self._share_container(obj, place, other, at) else gap) - EXACT:
                return False
        return True

    def _share_container(self, a: SceneObject, at: Vector, b: SceneObject, b_at: Vector) -> bool:
        containers = ((self.by_name[name], place) for name, place in self.positions.items())
        return any(
            contained(a, at, each, place) and contained(b, b_at, each, place)
            for each, place in containers
            if each.cavity is not None
        )

    def carriers(self) -> set[str]:
        """Return the names of the objects on or in which a movable object is."""
        return {
            below.name
            for item in self.by_name.values()
            for below in self.by_name.values()
            if item.movable and item is not below and {item.name, below.name} <= self.positions.keys()
            if self._carries(below, item)
        }

    def _carries(self, below: SceneObject, item: SceneObject) -> bool:
        at, place = self.positions[below.name], self.positions[item.name]
        if lies_in(item, place, below, at):
            return True
        rise = place[2] - item.size[2] / 2 - at[2] - top_for(below, item)
        return abs(rise) < 1e-4 and gap_from_above(item, place, below, at) < 0


def gap_from_above(a: SceneObject, at: Vector, b: SceneObject, b_at: Vector) -> float:
    """Return the larger of the gaps along x and y between two objects; negative where they overlap [m]."""
    return max(abs(at[axis] - b_at[axis]) - (a.size[axis] + b.size[axis]) / 2 for axis in (0, 1))


def resting_height(below: SceneObject, item: SceneObject) -> float:
    """Return the height of an item's bottom on or in an object, from that one's centre [m]."""
    return floor_in(below) if takes(below, item) else top_for(below, item)


def share_height(a: SceneObject, at: Vector, b: SceneObject, b_at: Vector) -> bool:
    """Return whether two objects are partly at the same height; a bowl nests in the one below."""
    (upper, upper_at), (lower, lower_at) = sorted(((a, at), (b, b_at)), key=lambda each: -each[1][2])
    return upper_at[2] - upper.size[2] / 2 < lower_at[2] + top_for(lower, upper) - EXACT


def contained(a: SceneObject, at: Vector, b: SceneObject, b_at: Vector) -> bool:
    """Return whether one of two objects is a container that the other lies in, clear of its walls."""
    return any(
        takes(outer, inner)
        and lies_in(inner, place, outer, outer_at)
        and fits_at(outer, inner, place[0] - outer_at[0], place[1] - outer_at[1])
        and place[2] - inner.size[2] / 2 > outer_at[2] + floor_in(outer) - EXACT
        for outer, outer_at, inner, place in ((a, at, b, b_at), (b, b_at, a, at))
    )


def fits_at(container: SceneObject, item: SceneObject, dx: float, dy: float, yaw: float = 0.0) -> bool:
    """Return whether an item is clear of a hollow's walls, so far from its middle [m]."""
    cavity = container.cavity
    assert cavity is not None, f"{container.name} is not hollow"
    corners = np.abs(_corners(item, (dx, dy), yaw))
    if container.shape == "bowl":  # what just fits lies in the middle
        at_middle = max(container.size[0] / 2 - BOWL_WALL, hypot(*item.size[:2]) / 2)
        return bool(np.hypot(*corners.T).max() < at_middle + EXACT)
    return bool((corners <= np.array(cavity[:2]) + EXACT).all())


def nests_badly(below: SceneObject, item: SceneObject) -> bool:
    """Return whether an item is a bowl that would sink into a wider container, by an unknown depth."""
    return has_room_for(below, item) and not takes(below, item)


# Turned objects ---------------------------------------------------------------------------------


def turned_where_free(scene: Scene, kept: Collection[str] = ()) -> Scene:
    """Return the scene with objects unturned whose corners would otherwise reach into others.

    Args:
        kept: objects that are left as they are turned.
    """
    yaws = dict(scene.yaws)
    close = _close_pairs(scene)
    while tight := [pair for pair in close if _clash(scene, yaws, *pair)]:
        turned = {obj.name for pair in tight for obj in pair if yaws.get(obj.name) and obj.name not in kept}
        if not turned:
            break
        yaws |= dict.fromkeys(turned, 0.0)
    return replace(scene, yaws=yaws)


def _close_pairs(scene: Scene) -> list[tuple[SceneObject, SceneObject]]:
    """Return the pairs that are partly at one height, and whose enclosing circles overlap."""
    objects = [obj for obj in scene.objects if obj.size[0] <= TOO_WIDE and obj.name in scene.positions]
    at = np.array([scene.positions[obj.name] for obj in objects]).reshape(-1, 3)
    reach = np.array([hypot(*obj.size[:2]) / 2 for obj in objects])
    half = np.array([obj.size[2] / 2 for obj in objects])
    apart = np.linalg.norm(at[:, None, :2] - at[None, :, :2], axis=-1)  # (N, N)
    level = np.abs(at[:, None, 2] - at[None, :, 2]) < half[:, None] + half[None] - EXACT
    close = level & (apart < reach[:, None] + reach[None])
    return [(objects[i], objects[j]) for i, j in zip(*np.nonzero(np.triu(close, 1)), strict=True)]


def _clash(scene: Scene, yaws: Mapping[str, float], a: SceneObject, b: SceneObject) -> bool:
    at, b_at = scene.positions[a.name], scene.positions[b.name]
    if not share_height(a, at, b, b_at):
        return False
    for outer, inner in ((a, b), (b, a)):
        place, outer_at = scene.positions[inner.name], scene.positions[outer.name]
        if takes(outer, inner) and lies_in(inner, place, outer, outer_at):
            dx, dy = place[0] - outer_at[0], place[1] - outer_at[1]
            return not fits_at(outer, inner, dx, dy, yaws.get(inner.name, 0.0))
    return _overlap(_corners(a, at, yaws.get(a.name, 0.0)), _corners(b, b_at, yaws.get(b.name, 0.0)))


def _overlap(a: Corners, b: Corners) -> bool:
    """Return whether two rectangles overlap, by the separating axis theorem."""
    for first, second, third in ((a[0], a[1], a[2]), (b[0], b[1], b[2])):
        for axis in (second - first, third - first):
            mine, other = a @ axis, b @ axis
            if mine.max() <= other.min() or other.max() <= mine.min():
                return False
    return True


def _corners(obj: SceneObject, at: tuple[float, ...], yaw: float) -> Corners:
    if obj.shape in ("cylinder", "bowl"):
        yaw = 0.0  # it is the same whichever way it is turned
    turn = np.array([[cos(yaw), -sin(yaw)], [sin(yaw), cos(yaw)]])
    half = np.array([(x * obj.size[0] / 2, y * obj.size[1] / 2) for x in (-1, 1) for y in (-1, 1)])
    corners: Corners = half @ turn.T + np.array(at[:2])
    return corners
