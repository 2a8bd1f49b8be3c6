"""Pushes of a body over the table with the fingertips: towards somewhere, or free of its neighbours."""

import itertools

import numpy as np

from kinematics.errors import KinematicsError, Obstructed, Reason
from kinematics.geometry.transforms import Array
from kinematics.skills import execution
from kinematics.skills.approach import Approach, grasp_approaches
from kinematics.skills.arm import CellSnapshot
from kinematics.skills.declutter import Nudge, asked_push, nudges
from kinematics.skills.skill_execution import Attempt

NUDGES = 4  # before a grasp is given up
SPEED = 0.1  # of the tool [m/s]
CORRECTIONS = 4  # looks at what is left
SHORT = 0.002  # what is left to push that is worth a correction [m]
PUSHED = 0.02  # from where it was to be, for a push to count [m]


def carry_out(attempt: Attempt, snapshot: CellSnapshot, nudge: Nudge) -> None:
    """Down beside the body, along, back off, and up to where the hand was."""
    _sweep(attempt, nudge)
    _withdraw(attempt, snapshot, nudge.sweep)


def approach_anew(attempt: Attempt, target: str) -> tuple[CellSnapshot, Approach]:
    """Move to where the way down is free; where none is, push things apart until one is."""
    for pushes in range(NUDGES + 1):
        snapshot = attempt.observe()
        found = grasp_approaches(attempt.arm, snapshot, target, attempt.shape(target), attempt.seed)
        free = (approach for approach in found if approach.is_free)
        first = next(free, None)
        if first is not None:
            return snapshot, attempt.go_above(snapshot, itertools.chain([first], free))
        nudge = next(nudges(attempt.arm, snapshot, target, attempt.cell.bodies, attempt.seed), None)
        if nudge is None or pushes == NUDGES:
            break
        attempt.evidence["nudges"] = attempt.evidence.get("nudges", 0) + 1
        carry_out(attempt, snapshot, nudge)
    count = attempt.evidence.get("nudges", 0)
    raise Obstructed(Reason.NO_GRASP, f"no grasp of '{target}' is free", nudges=count)


def push(attempt: Attempt, snapshot: CellSnapshot, target: str, shift: Array) -> None:
    """Push a body by a horizontal shift [m]: most of the way, then what a second look says is left.

    A body turns until it lies flat against the fingertips, and is then nearer to them, or farther.
    """
    arm, cell = attempt.arm, attempt.cell
    nudge = asked_push(arm, snapshot, target, cell.bodies, shift, attempt.seed)
    if nudge is None:
        raise Obstructed(Reason.GOAL_IN_COLLISION, f"no way of pushing '{target}' there is free")
    before = np.array(cell.observed_pose(target).position)
    _sweep(attempt, nudge)
    sweep = nudge.sweep
    for _ in range(CORRECTIONS):
        line = _rest_of_the_way(attempt, target, sweep, shift, before)
        if line is None:
            break
        execution.follow(cell, attempt.along(line, SPEED))
        sweep = np.concatenate([sweep, line[1:]])
    _withdraw(attempt, snapshot, sweep)
    cell.settle_until_still([target], execution.WAIT_FOR_FALL)
    moved = np.array(cell.observed_pose(target).position) - before
    off = float(np.linalg.norm((moved - shift)[:2]))
    attempt.evidence.update(moved=moved.tolist(), off=off)
    if off > PUSHED + execution.doubt(cell):
        message = f"'{target}' is {1000 * off:.0f} mm from where it was to be pushed"
        raise KinematicsError(Reason.PUSH_FAILED, message)


def _rest_of_the_way(
    attempt: Attempt, target: str, sweep: Array, shift: Array, before: Array
) -> Array | None:
    direction = shift / float(np.linalg.norm(shift))
    moved = np.array(attempt.cell.observed_pose(target).position) - before
    rest = float((shift - moved) @ direction)
    if rest < SHORT:
        return None
    end = attempt.arm.inverse.forward(sweep[-1])
    end[:3, 3] += rest * direction
    return attempt.arm.lines.follow(sweep[-1], [end])


def _sweep(attempt: Attempt, nudge: Nudge) -> None:
    cell = attempt.cell
    execution.open_hand(cell, nudge.opening)
    ready = attempt.observe()
    execution.follow(cell, attempt.plan_to(ready, nudge.above, ready.opening))
    execution.follow(cell, attempt.along(nudge.down))
    execution.follow(cell, attempt.along(nudge.sweep, SPEED))


def _withdraw(attempt: Attempt, snapshot: CellSnapshot, sweep: Array) -> None:
    """Back off, then up; the hand opens."""
    cell, arm = attempt.cell, attempt.arm
    execution.follow(cell, attempt.along(sweep[::-1][:3]))
    raised = arm.inverse.forward(sweep[-3])
    raised[2, 3] = snapshot.tool[2, 3]
    up = arm.lines.follow(sweep[-3], [raised])
    if up is not None:
        execution.follow(cell, attempt.along(up))
    attempt.open_wide()
