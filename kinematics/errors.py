"""Why a motion was not achieved: a closed set of reasons, and the exceptions that carry them.

KinematicsError                a motion cannot be done; has `.reason` and `.evidence`
+-- UnknownBody                a name that is not in the cell
+-- UnusablePose               not a number, or not a rotation
+-- UnsuitableHand             the hand is full, empty or closed, where the skill needs the opposite
+-- Unreachable                no joint positions, or no straight line, put the tool there
+-- Obstructed                 something stands where the arm, the hand or the held body would be
+-- NoPathFound                the planner used up its validity checks
+-- NoPlaceFound               the table has no free spot of that size

NoDisplay                      a window was asked for where none can be shown
UnusableShape                  a file that no shape can be made of, or a body without volume
UnusableRobot                  a URDF or its TOML that no arm can be made of: says what, and where
"""

from collections.abc import Iterable
from enum import StrEnum
from typing import Any


class Reason(StrEnum):
    """Every way in which a skill can fail. What the skill measured stands in `Motion.evidence`."""

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
    """A motion that cannot be done, and why. Skills turn it into a `Motion`."""

    def __init__(self, reason: Reason, message: str, **evidence: Any) -> None:
        super().__init__(message)
        self.reason = reason
        self.evidence = evidence


class UnusableShape(ValueError):
    """A file that no shape can be made of, or a body that has no volume or an impossible mass."""


class UnusableRobot(ValueError):
    """A description of an arm that something is wrong with: what was expected, found, and where."""


class NoDisplay(RuntimeError):
    """A window was asked for where none can be shown."""


class UnknownBody(KinematicsError):
    """A name that no body in the cell has."""

    def __init__(self, name: str, known: Iterable[str]) -> None:
        listed = sorted(known)
        message = f"nothing in the cell is called '{name}'; there are {', '.join(listed) or 'none'}"
        super().__init__(Reason.UNKNOWN_BODY, message, name=name, known=listed)


class UnusablePose(KinematicsError):
    """A pose that is not finite, or whose quaternion is not of length one."""

    def __init__(self, name: str, pose: object) -> None:
        message = f"'{name}' has no usable pose: {pose}"
        super().__init__(Reason.UNUSABLE_POSE, message, name=name, pose=str(pose))


class UnsuitableHand(KinematicsError):
    """The hand holds something where it must be empty, or the target itself; or it does not open so wide."""


class Unreachable(KinematicsError):
    """No joint positions within the limits put the tool there."""


class Obstructed(KinematicsError):
    """Something stands where the arm, the hand or the held body would be."""


class NoPathFound(KinematicsError):
    """The planner used up its validity checks."""


class NoPlaceFound(KinematicsError):
    """No spot of the table is free for a body of that size and the fingers around it."""
