"""From a body's pose to grasps of it, cheapest first.

A grasp closes on a pair of opposite surfaces. Its approach is as vertical as the pair allows, so a tilted
body is grasped by a tilted hand; turned about the closing direction, the fingers still meet the surfaces
flat.
"""

import itertools
import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from kinematics.geometry.transforms import (
    Array,
    Pose,
    check_pose,
    rotation_about,
    rotation_from_quaternion,
    transform_from,
)
from kinematics.grasping.contact_pairs import ContactPair, contact_pairs_of
from kinematics.robot.gripper import Gripper
from kinematics.shapes.shapes import Box, Shape, height_below, support

FINGER_DEPTH = 0.025  # of the tool below the top of the gripped part, at most [m]
LARGEST_TILT = math.radians(50)  # of a hand from the vertical
FINGER_ROOM = 0.015  # between body and each finger, where there is space [m]
NARROW_FINGER_ROOMS = (0.009, 0.005, 0.0035)  # where there is less
LEAST_OVERLAP = 2e-3  # of the fingertips with the gripped part, along the approach [m]
FINGERTIP_CLEARANCE = 1e-3  # above the support, for a body that is flatter than the fingers are long [m]
SWINGING_FINGERTIP_CLEARANCE = 2e-3  # for fingers that dip on closing: a support would spread them [m]

_TURNS = (0.0, 15.0, -15.0, 30.0, -30.0, 45.0, -45.0)  # about the closing direction [degrees]
_LIFTS = (0.0, 0.008, 0.014, 0.019)  # of the tool, so that the fingertips go in less deep [m]
_SHIFTS = (0.0, 0.006, -0.006, 0.012, -0.012)  # of the tool along its x, across the faces [m]


@dataclass(frozen=True)
class Grasp:
    """A pose of the tool in which the fingers close on a body."""

    tool: Array  # (4, 4) transform to the world
    centre: Array  # (3,) between the gripped surfaces, world frame [m]
    width: float  # of the body between the fingers [m]
    cost: float  # deviation from a plain grasp; 0 is plain
    widest: float  # maximum opening of a finger [m]
    offset: Array  # (3,) of the body's origin in the tool frame, if all goes as planned [m]

    @property
    def openings(self) -> list[float]:
        """Of each finger before it closes, widest first [m]."""
        rooms = (FINGER_ROOM, *NARROW_FINGER_ROOMS)
        openings = [min(self.widest, self.width / 2 + room) for room in rooms]
        return list(dict.fromkeys(openings))


def grasps_by_cost(pose: Pose, shape: Shape, gripper: Gripper) -> Iterator[list[Grasp]]:
    """Yield all grasps of a body in groups of equal cost, plain ones first; raise `UnusablePose`."""
    rotation = rotation_from_quaternion(check_pose("the body", pose).quaternion_xyzw)
    bottom = pose.position[2] - height_below(shape, rotation)
    closings = [
        closing
        for pair in contact_pairs_of(shape, pose)
        if pair.width <= largest_graspable_width(gripper)
        for closing in _closings(pair)
    ]
    variants = sorted(itertools.product(_TURNS, _LIFTS, _SHIFTS), key=_cost)
    for cost, group in itertools.groupby(variants, key=_cost):
        grasps = []
        for turn, lift, shift in group:
            for pair, closing, approach in closings:
                turned = rotation_about(closing, math.radians(turn)) @ approach
                if turned[2] > -math.cos(LARGEST_TILT):
                    continue
                tool = _tool_transform(closing, turned, pair.centre)
                raised = lift + _raised(pair, turned, bottom, gripper)
                if raised > _top(pair, turned) - LEAST_OVERLAP + _beyond(pair, gripper):
                    continue
                tool[:3, 3] -= turned * raised
                tool[:3, 3] += tool[:3, 0] * shift
                offset = tool[:3, :3].T @ (np.array(pose.position) - tool[:3, 3])
                widest = gripper.maximum_opening
                grasps.append(Grasp(tool, pair.centre, pair.width, cost, widest, offset))
        if grasps:
            yield grasps


def narrowest_width(pose: Pose, shape: Shape) -> float:
    """Return the least width of a body between fingers from above; infinite if there is no pair [m]."""
    pairs = contact_pairs_of(shape, pose)
    return min((pair.width for pair in pairs if any(_closings(pair))), default=math.inf)


def largest_graspable_width(gripper: Gripper) -> float:
    """Return the width of the widest body that the fingers fit around [m]."""
    return 2 * (gripper.maximum_opening - NARROW_FINGER_ROOMS[-1])


def _cost(variant: tuple[float, float, float]) -> float:
    turn, lift, shift = variant
    return abs(turn) / 15.0 + abs(lift) / 0.008 + abs(shift) / 0.006


def _closings(pair: ContactPair) -> Iterator[tuple[ContactPair, Array, Array]]:
    """Yield contact pair, closing direction and approach, both ways round."""
    normal = pair.normal
    approach = np.array([0.0, 0.0, -1.0]) + normal * normal[2]
    length = float(np.linalg.norm(approach))
    if length < math.cos(LARGEST_TILT):
        return
    for sign in (1.0, -1.0):
        yield pair, sign * normal, approach / length


def _raised(pair: ContactPair, approach: Array, bottom: float, gripper: Gripper) -> float:
    """Return how far the tool stays above the pair's centre: not too deep, and clear of the support [m]."""
    top = _top(pair, approach)
    tips = float(pair.centre[2]) - _beyond(pair, gripper)  # world height, were the tool in the centre
    clearance = FINGERTIP_CLEARANCE if gripper.slides else SWINGING_FINGERTIP_CLEARANCE
    return max(0.0, top - min(FINGER_DEPTH, pair.depth), bottom + clearance - tips)


def _beyond(pair: ContactPair, gripper: Gripper) -> float:
    """Return how far the fingertips reach beyond the tool while they close [m]."""
    return gripper.beyond_tool(pair.width / 2, pair.width / 2 + FINGER_ROOM)


def _top(pair: ContactPair, approach: Array) -> float:
    """Return the height of the gripped piece above the pair's centre, against the approach [m]."""
    rotation = rotation_from_quaternion(pair.piece_pose.quaternion_xyzw)
    own = rotation.T @ approach
    is_flat = not isinstance(pair.piece, Box) or float(np.abs(own).max()) > 0.999
    middle = float((np.array(pair.piece_pose.position) - pair.centre) @ -approach)
    return middle + support(pair.piece, -own) if is_flat else FINGER_DEPTH


def _tool_transform(closing: Array, approach: Array, position: Array) -> Array:
    (a, b, c), (x, y, z) = closing.tolist(), approach.tolist()
    across = np.array([b * z - c * y, c * x - a * z, a * y - b * x])
    return transform_from(np.array([across, closing, approach]).T, position)
