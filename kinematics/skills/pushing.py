"""Pushes of a body over the table with the fingertips: by a given shift, or to unblock a grasp."""

import itertools

import numpy as np

from kinematics.errors import KinematicsError, Obstructed, Reason
from kinematics.geometry.transforms import Array
from kinematics.skills import execution
from kinematics.skills.approach import Approach, grasp_approaches
from kinematics.skills.arm import CellSnapshot
from kinematics.skills.declutter import Push, push_by, unblocking_pushes
from kinematics.skills.skill_execution import SkillExecution

MOST_PUSHES = 4  # before a grasp is given up
SPEED = 0.1  # of the tool [m/s]
CORRECTIONS = 4  # of a push, each after a new observation
WORTH_CORRECTING = 0.002  # distance short of the goal [m]
TOLERANCE = 0.02  # on a body's final position, for a push to count [m]


def approach_anew(skill: SkillExecution, target: str) -> tuple[CellSnapshot, Approach]:
    """Move above a grasp with a free way down; if there is none, push bodies apart until there is."""
    pushes = 0
    while True:
        snapshot = skill.observe()
        found = grasp_approaches(skill.arm, snapshot, target, skill.shape(target), skill.seed)
        free = (approach for approach in found if approach.is_free)
        first = next(free, None)
        if first is not None:
            return snapshot, skill.go_above(snapshot, itertools.chain([first], free))
        push = next(unblocking_pushes(skill.arm, snapshot, target, skill.cell.bodies, skill.seed), None)
        if push is None or pushes == MOST_PUSHES:
            raise Obstructed(Reason.NO_GRASP, f"no grasp of '{target}' is free", pushes=pushes)
        pushes += 1
        skill.evidence["pushes"] = pushes
        _sweep(skill, push)
        _withdraw(skill, snapshot, push.sweep)


def push(skill: SkillExecution, snapshot: CellSnapshot, target: str, shift: Array) -> None:
    """Push a body by a horizontal shift [m]: most of the way, then by what a new observation says is left.

    A body turns until it lies flat against the fingertips, which brings it nearer to them, or farther away.
    """
    arm, cell = skill.arm, skill.cell
    planned = push_by(arm, snapshot, target, cell.bodies, shift, skill.seed)
    if planned is None:
        raise Obstructed(Reason.GOAL_IN_COLLISION, f"no push of '{target}' there is free of collisions")
    before = np.array(cell.observed_pose(target).position)
    _sweep(skill, planned)
    sweep = planned.sweep
    for _ in range(CORRECTIONS):
        line = _correction(skill, target, sweep, shift, before)
        if line is None:
            break
        execution.follow(cell, skill.along(line, SPEED))
        sweep = np.concatenate([sweep, line[1:]])
    _withdraw(skill, snapshot, sweep)
    cell.settle_until_still([target], execution.WAIT_FOR_FALL)
    moved = np.array(cell.observed_pose(target).position) - before
    error = float(np.linalg.norm((moved - shift)[:2]))
    skill.evidence.update(moved=moved.tolist(), position_error=error)
    if error > TOLERANCE + execution.position_uncertainty(cell):
        message = f"'{target}' ended {1000 * error:.0f} mm from its goal"
        raise KinematicsError(Reason.PUSH_FAILED, message)


def _correction(
    skill: SkillExecution, target: str, sweep: Array, shift: Array, before: Array
) -> Array | None:
    """Return the line on to the goal, or None if the body is near enough."""
    direction = shift / float(np.linalg.norm(shift))
    moved = np.array(skill.cell.observed_pose(target).position) - before
    short = float((shift - moved) @ direction)
    if short < WORTH_CORRECTING:
        return None
    end = skill.arm.inverse.forward(sweep[-1])
    end[:3, 3] += short * direction
    return skill.arm.lines.follow(sweep[-1], [end])


def _sweep(skill: SkillExecution, push: Push) -> None:
    """Go down beside the body, then push it."""
    cell = skill.cell
    execution.open_hand(cell, push.opening)
    ready = skill.observe()
    execution.follow(cell, skill.plan_to(ready, push.above, ready.opening))
    execution.follow(cell, skill.along(push.down))
    execution.follow(cell, skill.along(push.sweep, SPEED))


def _withdraw(skill: SkillExecution, snapshot: CellSnapshot, sweep: Array) -> None:
    """Back off, rise to the height of the snapshot, and open the hand."""
    cell, arm = skill.cell, skill.arm
    execution.follow(cell, skill.along(sweep[::-1][:3]))
    raised = arm.inverse.forward(sweep[-3])
    raised[2, 3] = snapshot.tool[2, 3]
    up = arm.lines.follow(sweep[-3], [raised])
    if up is not None:
        execution.follow(cell, skill.along(up))
    skill.open_wide()
