"""From a held body to tool orientations that stand it upright, least tilted first; and free places for it."""

import itertools
import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from kinematics.geometry.transforms import (
    Z_AXIS,
    Array,
    Pose,
    check_finite,
    check_rotation,
    check_transform,
    rotation_about,
    rotation_from_quaternion,
    transform_from,
)
from kinematics.grasping.grasps import LARGEST_TILT
from kinematics.robot.robot import Region
from kinematics.shapes.shapes import Box, Shape, half_extents_of, height_below, reach_of

_GRID = 0.02  # spacing of the places that are tried [m]
_ENOUGH_ROOM = 0.13  # around a place; more is not better [m]
_FINGERS = 0.02  # room for a finger beside the held body [m]
_YAW_TURNS = tuple(math.radians(angle) for angle in (0, 45, -45, 90, -90, 135, -135, 180))


@dataclass(frozen=True)
class Placement:
    """An orientation of the tool in which the held body stands upright on its support."""

    tool_rotation: Array  # (3, 3) to the world
    body_rotation: Array  # (3, 3) to the world
    body_from_tool: Array  # (3,) from the tool to the body's centre, world frame [m]
    height: float  # of the body's origin above its lowest point, as it will stand [m]
    tilt: float  # of the hand from the vertical [rad]

    def tool_over(self, x: float, y: float, body_height: float) -> Array:
        """Return the tool transform that puts the body's centre at (x, y, `body_height`), world frame [m]."""
        centre = np.array([x, y, body_height])
        return transform_from(self.tool_rotation, centre - self.body_from_tool)


def yaw_of(rotation: Array) -> float:
    """Return the yaw of a box that stands on any of its faces, between -45 and 45 degrees [rad]."""
    horizontal = [axis for axis in rotation.T if abs(axis[2]) < 0.75]
    x, y = horizontal[0][:2]
    return math.remainder(math.atan2(y, x), math.pi / 2)


def placements(tool_to_body: Array, shape: Shape, tool: Array, yaw: float) -> list[Placement]:
    """Return all ways of putting the body down, least tilted hand first.

    A box stands on any of its faces, at a yaw [rad]. Any other body is put down as it was picked up, with an
    upright hand that turns as little as possible from its rotation `tool` (3, 3). Raise `UnusablePose` for
    what is no rotation, or not finite.
    """
    check_transform("the body in the hand", tool_to_body)
    check_rotation("the tool", tool)
    check_finite("the yaw", yaw)
    if not isinstance(shape, Box):
        return [
            _as_held(tool_to_body, shape, rotation_about(Z_AXIS, turn) @ _levelled(tool))
            for turn in _YAW_TURNS
        ]
    base = rotation_about(Z_AXIS, yaw)
    found = []
    for face in _cube_rotations():
        body_rotation = base @ face
        tool_rotation = body_rotation @ tool_to_body[:3, :3].T
        tilt = math.acos(min(1.0, max(-1.0, -float(tool_rotation[2, 2]))))
        if tilt <= LARGEST_TILT:
            offset = tool_rotation @ tool_to_body[:3, 3]
            height = height_below(shape, body_rotation)
            found.append(Placement(tool_rotation, body_rotation, offset, height, tilt))
    return sorted(found, key=lambda placement: round(placement.tilt, 2))


def _levelled(tool: Array) -> Array:
    """Return the nearest tool rotation whose approach is straight down (3, 3)."""
    x = tool[:, 0] * (1.0, 1.0, 0.0)
    x = x / max(float(np.linalg.norm(x)), 1e-9)
    return np.array([x, np.cross(-Z_AXIS, x), -Z_AXIS]).T


def _as_held(tool_to_body: Array, shape: Shape, tool_rotation: Array) -> Placement:
    body_rotation = tool_rotation @ tool_to_body[:3, :3]
    offset = tool_rotation @ tool_to_body[:3, 3]
    return Placement(tool_rotation, body_rotation, offset, height_below(shape, body_rotation), 0.0)


def free_places(
    poses: Mapping[str, Pose], shapes: Mapping[str, Shape], held: str, region: Region
) -> list[tuple[float, float]]:
    """Return places on the table with room for the held body and the fingers, clearest first [m]."""
    own = _reach(shapes[held])
    others = [(pose.position, _footprint(pose, shapes[name])) for name, pose in poses.items() if name != held]
    scored = []
    for x, y in _grid_points(region):
        room = min(
            (math.hypot(x - position[0], y - position[1]) - reach for position, reach in others),
            default=math.inf,
        )
        if room > own + _FINGERS:
            scored.append((-min(room, _ENOUGH_ROOM), _from_middle(x, y, region), x, y))
    return [(x, y) for _, _, x, y in sorted(scored)]


def _grid_points(region: Region) -> Iterator[tuple[float, float]]:
    axes = []
    for low, high in region:
        count = max(1, round((high - low) / _GRID))
        axes.append([low + (high - low) * k / count for k in range(count + 1)])
    return itertools.product(axes[0], axes[1])


def _from_middle(x: float, y: float, region: Region) -> float:
    (low_x, high_x), (low_y, high_y) = region
    return round(math.hypot(x - (low_x + high_x) / 2, y - (low_y + high_y) / 2), 6)


def _reach(shape: Shape) -> float:
    """Return half the largest horizontal extent of a standing body, for a box on any of its faces [m]."""
    return math.hypot(*sorted(shape.half_extents)[1:]) if isinstance(shape, Box) else reach_of(shape)


def _footprint(pose: Pose, shape: Shape) -> float:
    """Return the radius of a vertical cylinder around the body [m]."""
    rotation = np.abs(rotation_from_quaternion(pose.quaternion_xyzw))
    upright = rotation.max(axis=0).min() > 0.99 and rotation[2].max() > 0.99
    if upright and (isinstance(shape, Box) or rotation[2, 2] > 0.99):
        return _reach(shape)
    return math.hypot(*half_extents_of(shape))


def _cube_rotations() -> Iterator[Array]:
    """Yield the 24 rotations that align a box's axes with the world's."""
    for axes in itertools.permutations(range(3)):
        for signs in itertools.product((1.0, -1.0), repeat=3):
            rotation = np.zeros((3, 3))
            for row, (column, sign) in enumerate(zip(axes, signs, strict=True)):
                rotation[row, column] = sign
            if np.linalg.det(rotation) > 0:
                yield rotation
