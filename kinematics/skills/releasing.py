"""How a held body leaves the hand: put on what is below, or dropped into a container."""

import numpy as np

from kinematics.errors import KinematicsError, Obstructed, Reason, Unreachable
from kinematics.geometry.transforms import Array
from kinematics.ik import differential_ik
from kinematics.shapes import containers
from kinematics.skills import execution
from kinematics.skills.approach import ABOVE_SUPPORT, RESTARTS, opening_that_is_free
from kinematics.skills.arm import LINE_MARGIN, CellSnapshot
from kinematics.skills.skill_execution import Attempt

STAYED = 0.005  # how far a body may be from where it was let go [m]
STAYS = 0.1  # how fast it may be then [m/s]
MAXIMUM_DROP = 1.0  # of a held body to what is below [m]
GENTLE = 0.06  # of a descent that feels its way [m/s]
SHAKES = 3  # of what does not fall
DROP = 0.01  # that a body falls into a container [m]


def release(attempt: Attempt, snapshot: CellSnapshot, held: str) -> None:
    """Put the body down on what is below, or drop it where that is a container."""
    attempt.solved_by(differential_ik.SOLVER)
    container = container_below(attempt, snapshot, held)
    spare = ABOVE_SUPPORT if container is None else DROP
    drop = attempt.arm.scene.drop_height(snapshot.q, snapshot.state, MAXIMUM_DROP) - spare
    snapshot, line = _straight_down(attempt, snapshot, max(0.0, drop))
    if container is None:
        _put(attempt, held, line, _opening_beside(attempt, snapshot, line))
    else:
        line, opening = _as_deep_as_free(attempt, snapshot, line)
        _drop(attempt, held, container, line, opening)


def container_below(attempt: Attempt, snapshot: CellSnapshot, held: str) -> str | None:
    """The highest container that the held body is over, and would go into."""
    shape, position = attempt.shape(held), snapshot.poses[held].position
    below = [
        name
        for name, pose in snapshot.poses.items()
        if name != held
        and containers.takes(attempt.shape(name), pose, shape)
        and containers.is_over(attempt.shape(name), pose, position)
    ]
    return max(below, key=lambda name: snapshot.poses[name].position[2], default=None)


def _straight_down(attempt: Attempt, snapshot: CellSnapshot, drop: float) -> tuple[CellSnapshot, Array]:
    """The line down by so much [m]; where the arm would have to fold over on the way, it first turns to
    another posture that holds the tool where it is.
    """
    arm, low = attempt.arm, snapshot.tool.copy()
    low[2, 3] -= drop
    line = arm.lines.follow(snapshot.q, [low])
    if line is not None:
        return snapshot, line
    for q in arm.solutions(snapshot.tool, snapshot.q, snapshot.state, attempt.seed, RESTARTS):
        if arm.lines.follow(q, [low]) is None or not attempt.turns_to(snapshot, q):
            continue
        snapshot = attempt.observe()
        line = arm.lines.follow(snapshot.q, [low])
        if line is not None:
            return snapshot, line
    raise Unreachable(Reason.UNREACHABLE, "no straight line leads down to the support")


def _opening_beside(attempt: Attempt, snapshot: CellSnapshot, line: Array) -> float:
    """How wide to open at the end of the way down, which must be free."""
    arm, state = attempt.arm, snapshot.state
    if not arm.chain_is_free(line[:-1], state, margin=0.0):
        near = {name for q in line[:-1] for touch in arm.scene.touches(q, state) for name in touch.names}
        raise Obstructed(Reason.GOAL_IN_COLLISION, "something stands beside the way down", near=sorted(near))
    width = 2 * snapshot.opening
    opening = opening_that_is_free(arm, state, line, width)
    return width / 2 + 0.004 if opening is None else opening


def _as_deep_as_free(attempt: Attempt, snapshot: CellSnapshot, line: Array) -> tuple[Array, float]:
    """As far into a container as hand and body keep clear of it and of what is in it."""
    arm = attempt.arm
    with_body = [arm.scene.is_free(q, snapshot.state, LINE_MARGIN) for q in line]
    narrow = snapshot.opening + 0.005
    released = snapshot.state.without_held().with_opening(min(narrow, arm.gripper.maximum_opening))
    without = [arm.scene.is_free(q, released, LINE_MARGIN) for q in line]
    depth = 1
    while depth < len(line) and with_body[depth] and without[depth]:
        depth += 1
    line = line[:depth]
    opening = opening_that_is_free(arm, snapshot.state, line, 2 * snapshot.opening)
    return line, narrow if opening is None else opening


def _put(attempt: Attempt, held: str, line: Array, opening: float) -> None:
    """Down, open, and up again by the same way; then see that the body stayed."""
    cell = attempt.cell
    line = _felt_for(attempt, held, line) if cell.noise.position else line
    down = attempt.along(line)
    if not cell.noise.position:
        drop = execution.carry(cell, down, execution.measure_grip(cell, held))
        if drop is not None:
            raise attempt.dropped(drop)
    put_at = np.array(cell.observed_pose(held).position)
    execution.let_go(cell, opening)
    execution.follow(cell, down.reversed())
    moved = float(np.linalg.norm(np.array(cell.observed_pose(held).position) - put_at))
    attempt.evidence.update(moved=moved, speed=cell.speed(held))
    if moved > STAYED + execution.doubt(cell) or cell.speed(held) > STAYS:
        cell.settle_until_still([held], execution.WAIT_FOR_FALL)
        raise KinematicsError(Reason.PLACEMENT_FAILED, f"'{held}' did not stay where it was put", moved=moved)


def _felt_for(attempt: Attempt, held: str, line: Array) -> Array:
    """Go down where the support may be higher than it was told, or lower, until it resists.

    The way that led there is returned.
    """
    cell, arm = attempt.cell, attempt.arm
    heights = np.array([arm.inverse.forward(q)[2, 3] for q in line])
    doubt = execution.doubt(cell)
    sure = max(1, int((heights > heights[-1] + doubt).sum()))
    if sure > 1:
        drop = execution.carry(cell, attempt.along(line[:sure]), execution.measure_grip(cell, held))
        if drop is not None:
            raise attempt.dropped(drop)
    lowest = arm.inverse.forward(line[-1])
    lowest[2, 3] -= doubt
    slow = arm.lines.follow(line[sure - 1], [lowest])
    if slow is None:
        raise Unreachable(Reason.UNREACHABLE, "no straight line leads down to where the support may be")
    gentle = attempt.along(slow, GENTLE)
    reached = gentle.positions[execution.lower(cell, gentle)]
    way = arm.inverse.forward(reached)[2, 3]
    passed = [q for q in slow if arm.inverse.forward(q)[2, 3] > way]
    return np.concatenate([line[: sure - 1], np.array(passed), reached[None]])


def _drop(attempt: Attempt, held: str, container: str, line: Array, opening: float) -> None:
    """Down, open, and up again; then see that the body lies in the container."""
    cell, down = attempt.cell, attempt.along(line)
    drop = execution.carry(cell, down, execution.measure_grip(cell, held))
    if drop is not None:
        raise attempt.dropped(drop)
    execution.open_hand(cell, opening)
    for _ in range(SHAKES):
        if held not in cell.touched():
            break
        execution.close_hand(cell)  # it hangs on one finger: take it anew, and let go once more
        execution.open_hand(cell, opening)
    execution.follow(cell, down.reversed())
    cell.settle_until_still([held], execution.WAIT_FOR_FALL)
    position = cell.pose(held).position
    attempt.evidence.update(container=container, lies_at=position)
    if not containers.is_inside(attempt.shape(container), cell.pose(container), position):
        message = f"'{held}' does not lie in '{container}'"
        raise KinematicsError(Reason.PLACEMENT_FAILED, message, lies_at=position)
