"""Execution: trajectories in, motor commands out, with an eye on what the hand holds."""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from kinematics.errors import KinematicsError, Reason
from kinematics.geometry.transforms import Array, transform_of
from kinematics.planning.trajectory import TIME_STEP, Trajectory
from kinematics.simulation.workcell import Workcell

WATCH_STEPS = 12  # between two looks at the held body: 50 ms
BRAKING_STEPS = 48  # of a motion that is broken off
ARRIVED = 0.004  # of every joint [rad]
ARRIVAL_STEPS = 60  # to wait for that, at most
SLIPPED = 0.012  # how far a held body may move in the hand [m]
SLIPPED_WIDTH = 0.006  # how much the fingers may come together or apart [m]
WAIT_FOR_FALL = 1.0  # [s]
CERTAIN = 4.0  # standard deviations of a look beyond which it is no error of the look
RESISTANCE = 8.0  # of a joint's torque to change within `FELT_STEPS` [N m]
SPRING_BACK = 1.5e-3  # of each finger, from what it pressed [m]
PARTING_SPEED = 0.02  # of each finger meanwhile [m/s]
FELT_STEPS = 4  # free motion changes it by less than 2 N m meanwhile


@dataclass(frozen=True)
class Drop:
    """What was noticed when a carried body was lost."""

    name: str
    at_fraction: float  # of the way
    finger_width: float  # [m]
    slid: float  # in the hand, when it was noticed [m]


@dataclass(frozen=True)
class Grip:
    """How a body sits in the hand."""

    name: str
    offset: Array  # (3,) from the tool to the body's centre, tool frame [m]
    width: float  # of the fingers [m]


def measure_grip(cell: Workcell, name: str) -> Grip:
    """How the body sits in the hand now."""
    tool = transform_of(cell.tool_pose())
    offset = tool[:3, :3].T @ (np.array(cell.observed_pose(name).position) - tool[:3, 3])
    return Grip(name, offset, cell.finger_width())


def doubt(cell: Workcell) -> float:
    """How far apart two looks at one thing may put it [m]."""
    return CERTAIN * math.sqrt(2) * cell.noise.position


def slid(cell: Workcell, grip: Grip) -> float:
    """How far the body has moved in the hand since the grip was measured [m]."""
    return float(np.linalg.norm(measure_grip(cell, grip.name).offset - grip.offset))


def is_lost(cell: Workcell, grip: Grip) -> bool:
    """By the finger width, the contact of both fingers, and the body's pose in the hand."""
    apart = abs(cell.finger_width() - grip.width) > SLIPPED_WIDTH
    return apart and cell.held() != grip.name or slid(cell, grip) > SLIPPED + doubt(cell)


def follow(cell: Workcell, trajectory: Trajectory) -> None:
    """Drive the arm along, and wait until it has arrived; `KinematicsError` where it does not."""
    _drive(cell, trajectory, lambda step: False)
    _arrive(cell, trajectory.positions[-1])


def carry(cell: Workcell, trajectory: Trajectory, grip: Grip, slip_at: float | None = None) -> Drop | None:
    """Drive the arm along with something in the hand. Stops, and says so, when that is lost."""
    slip_step = None if slip_at is None else int(slip_at * len(trajectory))

    def lost(step: int) -> bool:
        if step == slip_step:
            cell.weaken_fingers()
        return step % WATCH_STEPS == 0 and is_lost(cell, grip)

    stopped = _drive(cell, trajectory, lost)
    if stopped is None and slip_at is not None:  # the fall began too late to be noticed on the way
        cell.settle(WAIT_FOR_FALL / 4)
    if stopped is None and not is_lost(cell, grip):
        _arrive(cell, trajectory.positions[-1])
        return None
    fraction = 1.0 if stopped is None else stopped / len(trajectory)
    drop = Drop(grip.name, fraction, cell.finger_width(), slid(cell, grip))
    if stopped is not None:
        _brake(cell, trajectory, stopped)
    return drop


def lower(cell: Workcell, trajectory: Trajectory) -> int:
    """Drive down until something resists, and stay there: the step of the trajectory where that was.

    For a descent to a support whose height is not certain. Felt in the torques of the joints, which
    change slowly in free motion.
    """
    felt: list[Array] = []

    def resisted(step: int) -> bool:
        felt.append(cell.joint_torques())
        before = felt[max(0, step - FELT_STEPS)]
        return float(np.abs(felt[step] - before).max()) > RESISTANCE

    stopped = _drive(cell, trajectory, resisted)
    if stopped is None:
        return len(trajectory) - 1
    cell.drive_arm(trajectory.positions[stopped].tolist(), [0.0] * trajectory.positions.shape[1])
    cell.settle(10 * TIME_STEP)
    return stopped


def open_hand(cell: Workcell, opening: float) -> None:
    """Open the fingers, and wait until they are open (a neighbour may hold them up)."""
    cell.open_fingers(opening)
    _wait_for_fingers(cell)


def let_go(cell: Workcell, opening: float) -> None:
    """Open gently until nothing is pressed any more, then wide: pads that spring back move what they held."""
    cell.open_fingers(cell.finger_width() / 2 + SPRING_BACK, PARTING_SPEED)
    cell.settle(SPRING_BACK / PARTING_SPEED)
    open_hand(cell, opening)


def close_hand(cell: Workcell) -> None:
    """Close the fingers until they stand still."""
    cell.close_fingers()
    _wait_for_fingers(cell)
    cell.settle(0.05)


def _wait_for_fingers(cell: Workcell) -> None:
    width = cell.finger_width()
    for _ in range(30):
        cell.settle(8 * TIME_STEP)
        before, width = width, cell.finger_width()
        if abs(width - before) < 2e-4:
            return


def _drive(cell: Workcell, trajectory: Trajectory, ends: Callable[[int], bool]) -> int | None:
    """The step at which `ends` said so, or None at the end of the way.

    When the cell is told to stop, the arm brakes along the way that was checked, and holds still; what
    is in the hand stays there.
    """
    positions, velocities = trajectory.positions.tolist(), trajectory.velocities.tolist()
    try:
        for step, (position, velocity) in enumerate(zip(positions, velocities, strict=True)):
            cell.drive_arm(position, velocity)
            cell.step()
            if cell.is_told_to_stop:
                _brake(cell, trajectory, step)
                raise KinematicsError(
                    Reason.STOPPED, "told to stop", at_fraction=(step + 1) / len(trajectory)
                )
            if ends(step):
                return step
    except KeyboardInterrupt:
        cell.hold()
        raise
    return None


def _brake(cell: Workcell, trajectory: Trajectory, step: int) -> None:
    """Go on along the planned way, slower and slower: it is the way that was checked."""
    at = float(step)
    last = len(trajectory) - 1
    for k in range(1, BRAKING_STEPS + 1):
        rate = 1.0 - k / BRAKING_STEPS
        at = min(float(last), at + rate)
        low = int(at)
        high = min(low + 1, last)
        share = at - low
        position = trajectory.positions[low] * (1 - share) + trajectory.positions[high] * share
        cell.drive_arm(position.tolist(), (trajectory.velocities[low] * rate).tolist())
        cell.step()


def _arrive(cell: Workcell, goal: Array) -> None:
    cell.drive_arm(goal.tolist(), [0.0] * len(goal))
    for _ in range(ARRIVAL_STEPS // 6):
        cell.settle(6 * TIME_STEP)
        error = float(np.abs(cell.joint_positions() - goal).max())
        if error < ARRIVED / 4:
            return
    if error > ARRIVED:
        cell.hold()
        raise KinematicsError(Reason.NOT_ARRIVED, f"a joint stopped {error:.4f} rad short", error=error)
