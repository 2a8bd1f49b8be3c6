"""Containment: which objects lie in bins and bowls, from their shapes and positions."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from math import hypot

from ntp_dsl.semantics.geometry import Vector
from ntp_dsl.semantics.observation import SceneObject

HEAPED = 0.02  # of an object's middle above the rim, at which it still lies in a heaped bin [m]
NESTED = 0.008  # of a bowl in the one below it [m]


def has_room_for(container: SceneObject, item: SceneObject) -> bool:
    """Return whether the item fits into the hollow: a wider one rests on the rim."""
    return container.cavity is not None and item.reach < container.reach - 1e-6


def takes(container: SceneObject, item: SceneObject) -> bool:
    """Return whether an item released over the container falls in.

    A bowl that would not stand upright in the hollow rests on the rim, or in the bowl below.
    """
    if container.cavity is None or item.cavity is None:
        return has_room_for(container, item)
    return item.reach < min(container.cavity.half_x, container.cavity.half_y)


def is_over_hollow(container: SceneObject, at: Vector, x: float, y: float) -> bool:
    """Return whether a point is over the hollow of a container whose centre is at `at`, seen from above."""
    cavity = container.cavity
    return cavity is not None and abs(x - at[0]) <= cavity.half_x and abs(y - at[1]) <= cavity.half_y


def lies_in(item: SceneObject, at: Vector, container: SceneObject, container_at: Vector) -> bool:
    """Return whether the item lies in the hollow of the container, or heaped on its contents."""
    if not has_room_for(container, item):
        return False  # it lies or leans on the rim
    bottom, rim = (container_at[2] + side * container.size[2] / 2 for side in (-1, 1))
    x, y, z = at
    if container.shape == "bowl":  # anything higher lies in the bowl above
        near = hypot(x - container_at[0], y - container_at[1]) <= container.size[0] / 2
        return near and bottom < z <= rim
    return is_over_hollow(container, container_at, x, y) and bottom < z <= rim + HEAPED


def contents(
    container: SceneObject, objects: Iterable[SceneObject], positions: Mapping[str, Vector]
) -> list[str]:
    """Return the names of the movable objects in a container: they go where it goes."""
    if container.cavity is None or container.name not in positions:
        return []
    at = positions[container.name]
    return [
        item.name
        for item in objects
        if item.movable and item.name != container.name and item.name in positions
        if lies_in(item, positions[item.name], container, at)
    ]


def container_below(
    item: SceneObject, x: float, y: float, others: Iterable[tuple[SceneObject, Vector]]
) -> SceneObject | None:
    """Return the container that an item falls into when it is released at a point: the highest."""
    tops = [
        (at[2] + other.size[2] / 2, other)
        for other, at in others
        if takes(other, item) and is_over_hollow(other, at, x, y)
    ]
    return max(tops, key=lambda each: each[0])[1] if tops else None


def floor_in(container: SceneObject) -> float:
    """Return the height of the hollow's floor, from the container's centre [m]."""
    assert container.cavity is not None, f"{container.name} is not hollow"
    return container.cavity.floor - container.size[2] / 2


def top_for(below: SceneObject, item: SceneObject) -> float:
    """Return the height at which an item's bottom rests on top of an object, from that one's centre [m]."""
    return below.size[2] / 2 - (NESTED if item.shape == below.shape == "bowl" else 0.0)
