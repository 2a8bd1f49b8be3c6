"""Release of a held body: placed on its support, or dropped into a container."""

import numpy as np

from kinematics.errors import KinematicsError, Obstructed, Reason, Unreachable
from kinematics.geometry.transforms import Array
from kinematics.ik import differential_ik
from kinematics.shapes import containers
from kinematics.skills import execution
from kinematics.skills.approach import RELEASE_HEIGHT, RESTARTS, opening_that_is_free
from kinematics.skills.arm import LINE_MARGIN, CellSnapshot
from kinematics.skills.skill_execution import SkillExecution

STAYED = 0.005  # distance a body may move after its release [m]
AT_REST = 0.1  # speed it may have then [m/s]
MAXIMUM_DESCENT = 1.0  # of a held body to its support [m]
GUARDED_SPEED = 0.06  # of the tool, while it feels for the support [m/s]
SHAKES = 3  # of a body that hangs on a finger
DROP = 0.01  # height from which a body falls into a container [m]
NARROW_RELEASE = 0.004  # beyond the grip, of each finger, if neighbours leave no more room [m]
NARROW_DROP = 0.005  # the same in a container [m]


def release(skill: SkillExecution, snapshot: CellSnapshot, held: str) -> None:
    """Put the body down on its support, or drop it if that is a container."""
    skill.solved_by(differential_ik.SOLVER)
    container = container_below(skill, snapshot, held)
    height = RELEASE_HEIGHT if container is None else DROP
    descent = skill.arm.scene.drop_height(snapshot.q, snapshot.state, MAXIMUM_DESCENT) - height
    snapshot, line = _straight_down(skill, snapshot, max(0.0, descent))
    if container is None:
        _put(skill, held, line, _opening_beside(skill, snapshot, line))
    else:
        line, opening = _as_deep_as_free(skill, snapshot, line)
        _drop(skill, held, container, line, opening)


def container_below(skill: SkillExecution, snapshot: CellSnapshot, held: str) -> str | None:
    """Return the highest container that the held body is over and fits into."""
    shape, position = skill.shape(held), snapshot.poses[held].position
    below = [
        name
        for name, pose in snapshot.poses.items()
        if name != held
        and containers.accepts(skill.shape(name), pose, shape)
        and containers.is_over(skill.shape(name), pose, position)
    ]
    return max(below, key=lambda name: snapshot.poses[name].position[2], default=None)


def _straight_down(
    skill: SkillExecution, snapshot: CellSnapshot, descent: float
) -> tuple[CellSnapshot, Array]:
    """Return the line down by a distance [m].

    If the arm would have to fold over on the way, it first moves to another posture with the same tool pose.
    """
    arm, low = skill.arm, snapshot.tool.copy()
    low[2, 3] -= descent
    line = arm.lines.follow(snapshot.q, [low])
    if line is not None:
        return snapshot, line
    for q in arm.solutions(snapshot.tool, snapshot.q, snapshot.state, skill.seed, RESTARTS):
        if arm.lines.follow(q, [low]) is None or not skill.change_posture(snapshot, q):
            continue
        snapshot = skill.observe()
        line = arm.lines.follow(snapshot.q, [low])
        if line is not None:
            return snapshot, line
    raise Unreachable(Reason.UNREACHABLE, "no straight line leads down to the support")


def _opening_beside(skill: SkillExecution, snapshot: CellSnapshot, line: Array) -> float:
    """Return how wide to open at the end of the way down, which must be free [m]."""
    arm, state = skill.arm, snapshot.state
    if not arm.chain_is_free(line[:-1], state, margin=0.0):
        near = {name for q in line[:-1] for contact in arm.scene.contacts(q, state) for name in contact.names}
        raise Obstructed(Reason.GOAL_IN_COLLISION, "something stands beside the way down", near=sorted(near))
    width = 2 * snapshot.opening
    opening = opening_that_is_free(arm, state, line, width)
    return width / 2 + NARROW_RELEASE if opening is None else opening


def _as_deep_as_free(skill: SkillExecution, snapshot: CellSnapshot, line: Array) -> tuple[Array, float]:
    """Return the line as far into a container as hand and body keep clear, and the opening there [m]."""
    arm = skill.arm
    with_body = [arm.scene.is_free(q, snapshot.state, LINE_MARGIN) for q in line]
    narrow = snapshot.opening + NARROW_DROP
    released = snapshot.state.without_held().with_opening(min(narrow, arm.gripper.maximum_opening))
    without = [arm.scene.is_free(q, released, LINE_MARGIN) for q in line]
    depth = 1
    while depth < len(line) and with_body[depth] and without[depth]:
        depth += 1
    line = line[:depth]
    opening = opening_that_is_free(arm, snapshot.state, line, 2 * snapshot.opening)
    return line, narrow if opening is None else opening


def _put(skill: SkillExecution, held: str, line: Array, opening: float) -> None:
    """Go down, open, and go up again the same way; then verify that the body stayed."""
    cell = skill.cell
    line = _guarded_descent(skill, held, line) if cell.noise.position else line
    down = skill.along(line)
    if not cell.noise.position:
        drop = execution.carry(cell, down, execution.measure_grip(cell, held))
        if drop is not None:
            raise skill.drop_failure(drop)
    put_at = np.array(cell.observed_pose(held).position)
    execution.release(cell, opening)
    execution.follow(cell, down.reversed())
    moved = float(np.linalg.norm(np.array(cell.observed_pose(held).position) - put_at))
    skill.evidence.update(moved=moved, speed=cell.speed(held))
    if moved > STAYED + execution.position_uncertainty(cell) or cell.speed(held) > AT_REST:
        cell.settle_until_still([held], execution.WAIT_FOR_FALL)
        raise KinematicsError(Reason.PLACEMENT_FAILED, f"'{held}' did not stay where it was put", moved=moved)


def _guarded_descent(skill: SkillExecution, held: str, line: Array) -> Array:
    """Go down until the support resists, which may be higher than observed, or lower; return the path."""
    cell, arm = skill.cell, skill.arm
    heights = np.array([arm.inverse.forward(q)[2, 3] for q in line])
    uncertainty = execution.position_uncertainty(cell)
    safe = max(1, int((heights > heights[-1] + uncertainty).sum()))
    if safe > 1:
        drop = execution.carry(cell, skill.along(line[:safe]), execution.measure_grip(cell, held))
        if drop is not None:
            raise skill.drop_failure(drop)
    lowest = arm.inverse.forward(line[-1])
    lowest[2, 3] -= uncertainty
    rest = arm.lines.follow(line[safe - 1], [lowest])
    if rest is None:
        raise Unreachable(Reason.UNREACHABLE, "no straight line leads down to where the support may be")
    guarded = skill.along(rest, GUARDED_SPEED)
    reached = guarded.positions[execution.lower(cell, guarded)]
    height = arm.inverse.forward(reached)[2, 3]
    passed = [q for q in rest if arm.inverse.forward(q)[2, 3] > height]
    return np.concatenate([line[: safe - 1], np.array(passed), reached[None]])


def _drop(skill: SkillExecution, held: str, container: str, line: Array, opening: float) -> None:
    """Go down, open, and go up again; then verify that the body is in the container."""
    cell, down = skill.cell, skill.along(line)
    drop = execution.carry(cell, down, execution.measure_grip(cell, held))
    if drop is not None:
        raise skill.drop_failure(drop)
    execution.open_hand(cell, opening)
    for _ in range(SHAKES):
        if held not in cell.touched():
            break
        execution.close_hand(cell)  # it hangs on one finger: grip it again, and release once more
        execution.open_hand(cell, opening)
    execution.follow(cell, down.reversed())
    cell.settle_until_still([held], execution.WAIT_FOR_FALL)
    position = cell.pose(held).position
    skill.evidence.update(container=container, lies_at=position)
    if not containers.is_inside(skill.shape(container), cell.pose(container), position):
        message = f"'{held}' is not in '{container}'"
        raise KinematicsError(Reason.PLACEMENT_FAILED, message, lies_at=position)
