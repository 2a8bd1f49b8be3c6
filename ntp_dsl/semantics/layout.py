"""Where objects lie beside others, and how they are turned. Distances are in metres, angles in radians."""

from __future__ import annotations

from collections.abc import Mapping
from math import atan2, pi, radians, remainder

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ntp_dsl.semantics.free_space import FREE_GAP, SPARE, clearance, footprints, load, region_within
from ntp_dsl.semantics.geometry import Quaternion, Vector
from ntp_dsl.semantics.observation import Observation, SceneObject

TURNED = radians(5)  # up to which an angle counts as the one that was asked for
NEAR = 0.12  # from an object's side, up to which another is beside it
LEVEL = 0.015  # difference of two bottoms, up to which two objects lie at the same height
GAPS = (0.03, 0.045, 0.06, 0.075, 0.09, 0.105)  # from an object's side, at which there may be room
ALONG = (0.0, 0.3, -0.3, 0.6, -0.6, 0.85, -0.85)  # of half of both widths: how far off the middle of a side

# From the robot: the signs of x and y of the way from an object to what lies at that side of it.
SIDES: Mapping[str, tuple[int, int]] = {"left": (0, 1), "right": (0, -1), "front": (-1, 0), "behind": (1, 0)}

Places = list[tuple[float, float]]


def yaw(orientation: Quaternion) -> float:
    """Return the angle from the world's x axis to an object's, seen from above [rad].

    Of an object that stands on that axis it is its y axis instead.
    """
    x, y, z, w = orientation
    if abs(2 * (x * z - w * y)) > 0.9:
        return atan2(1 - 2 * (x * x + z * z), 2 * (x * y - w * z))
    return atan2(2 * (x * y + w * z), 1 - 2 * (y * y + z * z))


def angle_between_lines(some: float, other: float) -> float:
    """Return the angle from one direction to another [rad], -pi/2 .. pi/2: each may point either way."""
    return remainder(some - other, pi)


def turned(observation: Observation, item: str, to: float) -> bool:
    """Return whether the length of `item` lies at that angle to the x axis; half a turn is no difference."""
    if item not in observation.positions:
        return False
    return abs(angle_between_lines(yaw(observation.orientation(item)), to)) < TURNED


def aligned(observation: Observation, item: str, other: str) -> bool:
    """Return whether the lengths of two objects are parallel."""
    both = item in observation.positions and other in observation.positions and item != other
    return both and turned(observation, item, yaw(observation.orientation(other)))


def beside(observation: Observation, item: str, other: str, side: str) -> bool:
    """Return whether `item` lies next to `other`, at that side of it, and at the same height."""
    both = item in observation.positions and other in observation.positions and item != other
    if not both or observation.held in (item, other):
        return False
    low = bottom_of(observation, item)
    return abs(low - bottom_of(observation, other)) < LEVEL and _is_at_side(
        observation, observation.positions[item], item, other, side
    )


def over_side(observation: Observation, item: str, other: str, side: str) -> bool:
    """Return whether `item`, which is held, is over a free place at that side of `other`."""
    if other not in observation.positions or observation.held != item or item == other:
        return False
    at = observation.positions[item]
    is_there = _is_at_side(observation, at, item, other, side)
    return is_there and bool(_room(observation, at[:2], item, other) > FREE_GAP)


def room_beside(observation: Observation, item: str, other: str, side: str) -> bool:
    """Return whether there is a free place for `item` at that side of `other`."""
    return bool(places_beside(observation, item, other, side))


def places_beside(observation: Observation, item: str, other: str, side: str) -> Places:
    """Return the free places for an object at a side of another, best first [m].

    There are none beside one that lies on something else than a table or a tray.
    """
    if item == other or not {item, other} <= observation.positions.keys():
        return []
    size = observation.by_name[item].size
    obj, at = observation.by_name[other], observation.positions[other]
    across = 0 if SIDES[side][1] else 1  # the axis along that side of the object
    places = np.tile(np.array(at[:2]), (len(ALONG), len(GAPS), 1))
    places[..., across] += np.array(ALONG)[:, None] * (obj.size[across] + size[across]) / 2
    reach = (obj.size[1 - across] + size[1 - across]) / 2
    places[..., 1 - across] += SIDES[side][1 - across] * (reach + np.array(GAPS))
    flat = places.reshape(-1, 2)
    free = flat[_room(observation, flat, item, other) > FREE_GAP + SPARE]
    return [(x, y) for x, y in free.tolist()]


def bottom_of(observation: Observation, name: str) -> float:
    """Return the height of an object's lowest point [m]."""
    return observation.positions[name][2] - observation.by_name[name].size[2] / 2


def _is_at_side(observation: Observation, at: Vector, item: str, other: str, side: str) -> bool:
    size, obj = observation.by_name[item].size, observation.by_name[other]
    across = 0 if SIDES[side][1] else 1
    way = [a - b for a, b in zip(at, observation.positions[other], strict=True)]
    gap = SIDES[side][1 - across] * way[1 - across] - (size[1 - across] + obj.size[1 - across]) / 2
    return 0 < gap < NEAR and abs(way[across]) < (size[across] + obj.size[across]) / 2


def _room(observation: Observation, places: ArrayLike, item: str, other: str) -> NDArray[np.float64]:
    """Return the clearance of each place for an item on the surface that another object lies on [m].

    There is none, minus infinity, off that surface, nor where the other lies on anything but a surface.
    """
    at = np.asarray(places)
    size = observation.by_name[item].size
    below = _surface_below(observation, other)
    if below is None:
        return np.full(at.shape[:-1], -np.inf)
    others = footprints(observation, {item, *load(observation, item), below.name})
    region = np.array(region_within(below, observation.positions[below.name], size))
    is_inside = ((at >= region[:, 0]) & (at <= region[:, 1])).all(axis=-1)
    return np.where(is_inside, clearance(at, size, others), -np.inf)


def _surface_below(observation: Observation, name: str) -> SceneObject | None:
    """Return the table or tray that an object lies on: of those whose top is that high, the nearest."""
    x, y, _ = observation.positions[name]
    found: list[tuple[float, str]] = []
    for surface in observation.objects:
        if not surface.flat or surface.name not in observation.positions:
            continue
        at = observation.positions[surface.name]
        gap = abs(bottom_of(observation, name) - at[2] - surface.size[2] / 2)
        if gap < LEVEL and abs(x - at[0]) < surface.size[0] / 2 and abs(y - at[1]) < surface.size[1] / 2:
            found.append((gap, surface.name))
    return observation.by_name[min(found)[1]] if found else None
