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

import reprlib
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from enum import StrEnum
from pathlib import Path
from typing import Any

_LONGEST_MESSAGE = 1500  # characters


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

    def __init__(self, message: str) -> None:
        super().__init__(_one_line(message))


class UnusableRobot(ValueError):
    """A faulty description of an arm: what was expected, what was found, and where."""

    def __init__(self, message: str) -> None:
        super().__init__(_one_line(message))


def shown(value: object) -> str:
    """Return a value found in a file, for a message; abridged, however long or deep it is."""
    return _Abridged().repr(value)


@contextmanager
def unforeseen_is_unusable(path: Path) -> Iterator[None]:
    """Turn what no check of an arm's files foresaw into an `UnusableRobot` that asks for a report."""
    try:
        yield
    except (UnusableRobot, UnusableShape):
        raise
    except Exception as unexpected:
        raise UnusableRobot(
            f"{path}: no arm can be made of it ({type(unexpected).__name__}: {unexpected}); no check foresaw "
            "this, so please report it, with the file"
        ) from unexpected


class _Abridged(reprlib.Repr):
    def __init__(self) -> None:
        super().__init__()
        self.maxlist = self.maxtuple = self.maxdict = self.maxset = 12
        self.maxstring = self.maxother = self.maxlong = 80
        self.maxlevel = 4


def _one_line(message: str) -> str:
    """Return a message without line breaks and control characters, which names in files may have."""
    line = " ".join(message.split())
    printable = "".join(c if c.isprintable() else ascii(c)[1:-1] for c in line)
    return printable if len(printable) <= _LONGEST_MESSAGE else f"{printable[:_LONGEST_MESSAGE]}…"


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
