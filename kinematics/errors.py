"""Why a motion was not achieved: a closed set of reasons, and the exceptions that carry them.

KinematicsError                an impossible or failed motion; has `.reason` and `.evidence`
+-- UnknownBody                a name that no body of the cell has
+-- UnusablePose               not finite, or not a rotation
+-- UnsuitableHand             the hand is full, empty or closed when the skill needs the opposite
+-- Unreachable                no joint positions, or no straight line, put the tool there
+-- Obstructed                 something stands where the arm, the hand or the held body would be
+-- NoPathFound                the planner used up its validity checks
+-- NoPlaceFound               no free place of that size

NoDisplay                      a window was requested, and there is no display
UnusableShape                  a file that describes no shape, or a body without volume
UnusableRobot                  a URDF or TOML that describes no arm: says what is wrong, and where
"""

from collections.abc import Iterable
from enum import StrEnum
from typing import Any


class Reason(StrEnum):
    """Every way in which a skill can fail; `Motion.evidence` has what the skill measured."""

    UNKNOWN_BODY = "unknown_body"
    UNUSABLE_POSE = "unusable_pose"
    UNREACHABLE = "unreachable"
    HAND_FULL = "hand_full"
    HAND_CLOSED = "hand_closed"
    TARGET_IN_HAND = "target_in_hand"
    NOT_ABOVE = "not_above"
    START_IN_COLLISION = "start_in_collision"
    GOAL_IN_COLLISION = "goal_in_collision"
    NO_PATH = "no_path"
    SUPPORT_TILTED = "support_tilted"
    NO_GRASP = "no_grasp"
    NO_FREE_PLACE = "no_free_place"
    GRASP_FAILED = "grasp_failed"
    GRASP_SLIPPED = "grasp_slipped"
    OBJECT_DROPPED = "object_dropped"
    PLACEMENT_FAILED = "placement_failed"
    PUSH_FAILED = "push_failed"
    NOT_ARRIVED = "not_arrived"
    STOPPED = "stopped"


class KinematicsError(Exception):
    """An impossible or failed motion, and why; skills turn it into a `Motion`."""

    def __init__(self, reason: Reason, message: str, **evidence: Any) -> None:
        super().__init__(message)
        self.reason = reason
        self.evidence = evidence


class UnusableShape(ValueError):
    """A file that describes no shape, or a body without volume or with an impossible mass."""


class UnusableRobot(ValueError):
    """A faulty description of an arm: what was expected, what was found, and where."""


class NoDisplay(RuntimeError):
    """A window was requested, and there is no display."""


class UnknownBody(KinematicsError):
    """A name that no body of the cell has."""

    def __init__(self, name: str, known: Iterable[str]) -> None:
        listed = sorted(known)
        message = f"no body in the cell is called '{name}'; there are {', '.join(listed) or 'none'}"
        super().__init__(Reason.UNKNOWN_BODY, message, name=name, known=listed)


class UnusablePose(KinematicsError):
    """A pose that is not finite, whose quaternion is not of length one, or whose matrix is no rotation."""

    def __init__(self, name: str, pose: object) -> None:
        message = f"'{name}' has no usable pose: {pose}"
        super().__init__(Reason.UNUSABLE_POSE, message, name=name, pose=str(pose))


class UnsuitableHand(KinematicsError):
    """The hand holds a body when it must be empty, or the target itself; or it does not open wide enough."""


class Unreachable(KinematicsError):
    """No joint positions within the limits put the tool there."""


class Obstructed(KinematicsError):
    """Something stands where the arm, the hand or the held body would be."""


class NoPathFound(KinematicsError):
    """The planner used up its validity checks."""


class NoPlaceFound(KinematicsError):
    """No place is free for a body of that size and the fingers around it."""
