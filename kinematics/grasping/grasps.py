"""From a body's pose to the ways of grasping it, best first.

A grasp closes on a pair of opposite places of the body. The approach is as vertical as these allow, so
that a tilted body is grasped by a tilted hand; turned about the closing direction it still meets the
body flatly.
"""

import itertools
import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from kinematics.geometry.transforms import (
    Array,
    Pose,
    rotation_about,
    rotation_from_quaternion,
    transform_from,
)
from kinematics.grasping.contact_pairs import Grip, grips_of
from kinematics.robot.gripper import Gripper
from kinematics.shapes.shapes import Box, Shape, height_below, support

FINGER_DEPTH = 0.025  # of the tool below the top of what is gripped, at most [m]
LARGEST_TILT = math.radians(50)  # of the approach from the vertical
FINGER_ROOM = 0.015  # beside the body, of each finger, where there is space [m]
NARROW_FINGER_ROOMS = (0.009, 0.005, 0.0035)  # where there is less
BITE = 2e-3  # of the fingertips below the top of what they close on, at least [m]
ABOVE_SUPPORT = 1e-3  # of the fingertips, when a body is flatter than they are long [m]
SWINGING_ABOVE_SUPPORT = 2e-3  # the same where they dip on closing: what is below would spread them [m]

_TURNS = (0.0, 15.0, -15.0, 30.0, -30.0, 45.0, -45.0)  # about the closing direction [degrees]
_LIFTS = (0.0, 0.008, 0.014, 0.019)  # of the tool, so that the fingertips go in less deep [m]
_SHIFTS = (0.0, 0.006, -0.006, 0.012, -0.012)  # of the tool along its x, across the faces [m]


@dataclass(frozen=True)
class Grasp:
    """Where the tool is to be when the fingers close."""

    tool: Array  # (4, 4) transform to the world
    centre: Array  # (3,) of what is gripped, world frame [m]
    width: float  # of the body between the fingers [m]
    trouble: float  # how far from the plain grasp
    widest: float  # that a finger opens [m]
    offset: Array  # (3,) of the body's origin in the tool frame, if all goes as planned [m]

    @property
    def openings(self) -> list[float]:
        """Of each finger before it closes, widest first [m]."""
        rooms = (FINGER_ROOM, *NARROW_FINGER_ROOMS)
        openings = [min(self.widest, self.width / 2 + room) for room in rooms]
        return list(dict.fromkeys(openings))


def grasps_by_trouble(pose: Pose, shape: Shape, gripper: Gripper) -> Iterator[list[Grasp]]:
    """All grasps of a body, in groups of equal trouble: plain ones first, contortions last."""
    rotation = rotation_from_quaternion(pose.quaternion_xyzw)
    bottom = pose.position[2] - height_below(shape, rotation)
    closings = [
        closing
        for grip in grips_of(shape, pose)
        if grip.width <= greatest_width(gripper)
        for closing in _closings(grip)
    ]
    variants = sorted(itertools.product(_TURNS, _LIFTS, _SHIFTS), key=_trouble)
    for trouble, group in itertools.groupby(variants, key=_trouble):
        grasps = []
        for turn, lift, shift in group:
            for grip, closing, approach in closings:
                turned = rotation_about(closing, math.radians(turn)) @ approach
                if turned[2] > -math.cos(LARGEST_TILT):
                    continue
                tool = _tool_transform(closing, turned, grip.centre)
                raised = lift + _raised(grip, turned, bottom, gripper)
                if raised > _top(grip, turned) - BITE + _beyond(grip, gripper):
                    continue
                tool[:3, 3] -= turned * raised
                tool[:3, 3] += tool[:3, 0] * shift
                offset = tool[:3, :3].T @ (np.array(pose.position) - tool[:3, 3])
                widest = gripper.maximum_opening
                grasps.append(Grasp(tool, grip.centre, grip.width, trouble, widest, offset))
        if grasps:
            yield grasps


def least_width(pose: Pose, shape: Shape) -> float:
    """Between any two sides that fingers could close on from above; infinite where there are none [m]."""
    return min((grip.width for grip in grips_of(shape, pose) if any(_closings(grip))), default=math.inf)


def greatest_width(gripper: Gripper) -> float:
    """Of what the fingers get around [m]."""
    return 2 * (gripper.maximum_opening - NARROW_FINGER_ROOMS[-1])


def _trouble(variant: tuple[float, float, float]) -> float:
    turn, lift, shift = variant
    return abs(turn) / 15.0 + abs(lift) / 0.008 + abs(shift) / 0.006


def _closings(grip: Grip) -> Iterator[tuple[Grip, Array, Array]]:
    """Grip, closing direction and approach, both ways round."""
    normal = grip.normal
    approach = np.array([0.0, 0.0, -1.0]) + normal * normal[2]
    length = float(np.linalg.norm(approach))
    if length < math.cos(LARGEST_TILT):
        return
    for sign in (1.0, -1.0):
        yield grip, sign * normal, approach / length


def _raised(grip: Grip, approach: Array, bottom: float, gripper: Gripper) -> float:
    """How far from the grip's centre the tool stays: not too deep in what is tall, off what is below."""
    top = _top(grip, approach)
    tips = float(grip.centre[2]) - _beyond(grip, gripper)  # world height, were the tool in the centre
    above = ABOVE_SUPPORT if gripper.slides else SWINGING_ABOVE_SUPPORT
    return max(0.0, top - min(FINGER_DEPTH, grip.depth), bottom + above - tips)


def _beyond(grip: Grip, gripper: Gripper) -> float:
    """Of the fingertips beyond the tool, at most, while they close [m]."""
    return gripper.beyond_tool(grip.width / 2, grip.width / 2 + FINGER_ROOM)


def _top(grip: Grip, approach: Array) -> float:
    """Of the gripped piece above the grip's centre, against the approach [m]."""
    rotation = rotation_from_quaternion(grip.piece_pose.quaternion_xyzw)
    own = rotation.T @ approach
    is_flat = not isinstance(grip.piece, Box) or float(np.abs(own).max()) > 0.999
    middle = float((np.array(grip.piece_pose.position) - grip.centre) @ -approach)
    return middle + support(grip.piece, -own) if is_flat else FINGER_DEPTH


def _tool_transform(closing: Array, approach: Array, position: Array) -> Array:
    (a, b, c), (x, y, z) = closing.tolist(), approach.tolist()
    across = np.array([b * z - c * y, c * x - a * z, a * y - b * x])
    return transform_from(np.array([across, closing, approach]).T, position)
