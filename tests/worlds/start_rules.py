"""What must hold of every start: no two objects overlap, and nothing hangs in the air."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import combinations
from math import cos, sin

import numpy as np

from ntp_dsl.semantics.containers import floor_in, lies_in, takes, top_for
from ntp_dsl.semantics.observation import TOO_WIDE, SceneObject
from ntp_dsl.worlds.protocol import Scene

EXACT = 1e-6  # [m]
SLOPPY = 0.0002  # below which turned boxes count as beside each other [m]


def faults(scene: Scene) -> list[str]:
    """Return what is impossible about a start, in words."""
    return [*_overlaps(scene), *_hanging(scene)]


def _overlaps(scene: Scene) -> Iterator[str]:
    standing = [obj for obj in scene.objects if obj.size[0] <= TOO_WIDE and obj.name in scene.positions]
    for a, b in combinations(standing, 2):
        if _overlap(scene, a, b) and not (_contains(scene, a, b) or _contains(scene, b, a)):
            yield f"{a.name} and {b.name} overlap"


def _overlap(scene: Scene, a: SceneObject, b: SceneObject) -> bool:
    """Return whether two objects overlap, as they stand and as they would unturned."""
    bottom, top = sorted((a, b), key=lambda obj: scene.positions[obj.name][2])
    sunk = (
        top.size[2] / 2
        + top_for(bottom, top)
        - (scene.positions[top.name][2] - scene.positions[bottom.name][2])
    )
    if sunk < EXACT:
        return False
    gaps = [
        abs(scene.positions[a.name][axis] - scene.positions[b.name][axis]) - (a.size[axis] + b.size[axis]) / 2
        for axis in (0, 1)
    ]
    return max(gaps) < -EXACT or turned_gap(scene, a, b) < -SLOPPY


def turned_gap(scene: Scene, a: SceneObject, b: SceneObject) -> float:
    """Return the gap between two objects seen from above, turned as they are, by the separating axes [m]."""
    corners = [_corners(scene, obj) for obj in (a, b)]
    gaps = []
    for obj in (a, b):
        yaw = _yaw(scene, obj)
        for axis in ((cos(yaw), sin(yaw)), (-sin(yaw), cos(yaw))):
            (low, high), (other_low, other_high) = (
                (min(spread), max(spread)) for spread in (each @ np.array(axis) for each in corners)
            )
            gaps.append(max(other_low - high, low - other_high))
    return float(max(gaps))


def _yaw(scene: Scene, obj: SceneObject) -> float:
    is_round = obj.shape in ("cylinder", "bowl")
    return 0.0 if is_round else scene.yaws.get(obj.name, 0.0)


def _corners(scene: Scene, obj: SceneObject) -> np.ndarray:
    yaw = _yaw(scene, obj)
    turn = np.array([[cos(yaw), -sin(yaw)], [sin(yaw), cos(yaw)]])
    half = np.array([(x * obj.size[0] / 2, y * obj.size[1] / 2) for x in (-1, 1) for y in (-1, 1)])
    return half @ turn.T + np.array(scene.positions[obj.name][:2])  # (4, 2)


def _contains(scene: Scene, container: SceneObject, item: SceneObject) -> bool:
    at, container_at = scene.positions[item.name], scene.positions[container.name]
    if not lies_in(item, at, container, container_at) or not takes(container, item):
        return False
    return at[2] - item.size[2] / 2 > container_at[2] + floor_in(container) - EXACT


def _hanging(scene: Scene) -> Iterator[str]:
    for obj in scene.objects:
        if obj.movable and obj.name in scene.positions and obj.name != scene.held:
            if not _rests(scene, obj):
                yield f"{obj.name} hangs in the air"


def _rests(scene: Scene, item: SceneObject) -> bool:
    """Return whether an object's centre is over what its bottom touches: the table, an object, a floor.

    What lies in the held bowl is carried with it.
    """
    x, y, z = scene.positions[item.name]
    bottom = z - item.size[2] / 2
    if abs(bottom) < EXACT:
        return True
    for below in scene.objects:
        if below is item or below.name not in scene.positions:
            continue
        bx, by, bz = scene.positions[below.name]
        on_top = [] if below.name == scene.held else [bz + top_for(below, item)]
        floors = on_top + ([bz + floor_in(below)] if takes(below, item) else [])
        touches = any(abs(bottom - floor) < EXACT for floor in floors)
        if touches and abs(x - bx) <= below.size[0] / 2 and abs(y - by) <= below.size[1] / 2:
            return True
    return False
