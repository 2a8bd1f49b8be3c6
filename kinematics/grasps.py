"""From a box's pose to the ways of grasping it, best first.

A grasp closes on a pair of opposite faces. The approach is as vertical as those faces allow, so
that a tilted
box is grasped by a tilted hand; turned about the closing direction it still meets the faces flatly.
"""

import itertools
import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from kinematics import robot
from kinematics.geometry import (
    Array,
    Pose,
    Vector,
    rotation_about,
    rotation_from_quaternion,
    transform_from,
)

FINGER_DEPTH = 0.025  # of the tool below the body's top, at most [m]
LARGEST_TILT = math.radians(50)  # of the approach from the vertical
FINGER_ROOM = 0.015  # beside the body, of each finger, where there is space [m]
NARROW_FINGER_ROOMS = (0.009, 0.005, 0.0035)  # where there is less

_TURNS = (0.0, 15.0, -15.0, 30.0, -30.0, 45.0, -45.0)  # about the closing direction [degrees]
_LIFTS = (
    0.0,
    0.008,
    0.014,
    0.019,
)  # of the tool along the body, so that the fingertips go in less deep [m]
_SHIFTS = (0.0, 0.006, -0.006, 0.012, -0.012)  # of the tool along its x, across the faces [m]


@dataclass(frozen=True)
class Grasp:
    """Where the tool is to be when the fingers close."""

    tool: Array  # (4, 4) transform to the world
    width: float  # of the body between the fingers [m]
    trouble: float  # how far from the plain grasp

    @property
    def openings(self) -> list[float]:
        """Of each finger before it closes, widest first [m]."""
        rooms = (FINGER_ROOM, *NARROW_FINGER_ROOMS)
        openings = [min(robot.MAXIMUM_OPENING, self.width / 2 + room) for room in rooms]
        return list(dict.fromkeys(openings))


def grasps_by_trouble(pose: Pose, half_extents: Vector) -> Iterator[list[Grasp]]:
    """All grasps of a box, in groups of equal trouble: plain ones first, contortions last."""
    rotation = rotation_from_quaternion(pose.quaternion_xyzw)
    closings = list(_closings(rotation, half_extents))
    variants = sorted(itertools.product(_TURNS, _LIFTS, _SHIFTS), key=_trouble)
    for trouble, group in itertools.groupby(variants, key=_trouble):
        grasps = []
        for turn, lift, shift in group:
            for closing, approach, width in closings:
                turned = rotation_about(closing, math.radians(turn)) @ approach
                if turned[2] > -math.cos(LARGEST_TILT):
                    continue
                depth = _extent(turned, rotation, half_extents)
                tool = _tool_transform(closing, turned, np.array(pose.position))
                tool[:3, 3] -= turned * (lift + max(0.0, depth - FINGER_DEPTH))
                tool[:3, 3] += tool[:3, 0] * shift
                grasps.append(Grasp(tool, width, trouble))
        if grasps:
            yield grasps


def _trouble(variant: tuple[float, float, float]) -> float:
    turn, lift, shift = variant
    return abs(turn) / 15.0 + abs(lift) / 0.008 + abs(shift) / 0.006


def _closings(rotation: Array, half_extents: Vector) -> Iterator[tuple[Array, Array, float]]:
    """Closing direction, approach and width, both ways round for every pair of faces that fits."""
    for axis in range(3):
        width = 2 * half_extents[axis]
        if width / 2 + NARROW_FINGER_ROOMS[-1] > robot.MAXIMUM_OPENING:
            continue
        normal = rotation[:, axis]
        approach = np.array([0.0, 0.0, -1.0]) + normal * normal[2]
        length = float(np.linalg.norm(approach))
        if length < math.cos(LARGEST_TILT):
            continue
        for sign in (1.0, -1.0):
            yield sign * normal, approach / length, width


def _extent(direction: Array, rotation: Array, half_extents: Vector) -> float:
    """From the centre to the farthest point of the box along a direction, flat faces counted as
    they lie [m].
    """
    components = np.abs(rotation.T @ direction)
    return float(components @ np.asarray(half_extents)) if components.max() > 0.999 else FINGER_DEPTH


def _tool_transform(closing: Array, approach: Array, position: Array) -> Array:
    (a, b, c), (x, y, z) = closing.tolist(), approach.tolist()
    across = np.array([b * z - c * y, c * x - a * z, a * y - b * x])
    return transform_from(np.array([across, closing, approach]).T, position)
