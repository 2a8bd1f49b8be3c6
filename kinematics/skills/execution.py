"""From trajectories to motor commands; watches the held body meanwhile."""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from kinematics.errors import KinematicsError, Reason
from kinematics.geometry.transforms import Array, transform_of
from kinematics.planning.trajectory import TIME_STEP, Trajectory
from kinematics.simulation.cell import Cell

WATCH_STEPS = 12  # between two observations of the held body: 50 ms
BRAKING_STEPS = 48  # of an aborted motion
ARRIVED = 0.004  # error of every joint [rad]
ARRIVAL_STEPS = 60  # to wait for that, at most
SLIPPED = 0.012  # distance a held body may move in the hand [m]
SLIPPED_WIDTH = 0.006  # change of the finger width that counts as a slip [m]
WAIT_FOR_FALL = 1.0  # [s]
CERTAIN = 4.0  # standard deviations of an observation; beyond, a difference is real
RESISTANCE = 8.0  # change of a joint's torque within `FELT_STEPS` that means contact [N m]
FELT_STEPS = 4  # in which free motion changes a torque by less than 2 N m
SPRING_BACK = 1.5e-3  # of each finger's pad, once it no longer presses [m]
PARTING_SPEED = 0.02  # of each finger meanwhile [m/s]


@dataclass(frozen=True)
class Drop:
    """The loss of a carried body."""

    name: str
    at_fraction: float  # of the trajectory
    finger_width: float  # [m]
    slid: float  # distance in the hand, when it was noticed [m]


@dataclass(frozen=True)
class Grip:
    """How a body sits in the hand."""

    name: str
    offset: Array  # (3,) from the tool to the body's centre, tool frame [m]
    width: float  # of the fingers [m]


def measure_grip(cell: Cell, name: str) -> Grip:
    """Return how the body sits in the hand now."""
    tool = transform_of(cell.tool_pose())
    offset = tool[:3, :3].T @ (np.array(cell.observed_pose(name).position) - tool[:3, 3])
    return Grip(name, offset, cell.finger_width())


def position_uncertainty(cell: Cell) -> float:
    """Return how far two observations of one body may differ by noise alone [m]."""
    return CERTAIN * math.sqrt(2) * cell.noise.position


def slip_distance(cell: Cell, grip: Grip) -> float:
    """Return how far the body has moved in the hand since the grip was measured [m]."""
    return float(np.linalg.norm(measure_grip(cell, grip.name).offset - grip.offset))


def is_lost(cell: Cell, grip: Grip) -> bool:
    """Return whether the body is lost, by finger width, contact of both fingers, and its pose in the hand."""
    apart = abs(cell.finger_width() - grip.width) > SLIPPED_WIDTH
    return (
        apart and cell.held() != grip.name or slip_distance(cell, grip) > SLIPPED + position_uncertainty(cell)
    )


def follow(cell: Cell, trajectory: Trajectory) -> None:
    """Drive the arm along, and wait until it has arrived; `KinematicsError` if it does not."""
    _drive(cell, trajectory, lambda step: False)
    _arrive(cell, trajectory.positions[-1])


def carry(cell: Cell, trajectory: Trajectory, grip: Grip, slip_at: float | None = None) -> Drop | None:
    """Drive the arm along with a body in the hand; brake and return a `Drop` when it is lost."""
    slip_step = None if slip_at is None else int(slip_at * len(trajectory))

    def lost(step: int) -> bool:
        if step == slip_step:
            cell.weaken_fingers()
        return step % WATCH_STEPS == 0 and is_lost(cell, grip)

    stopped = _drive(cell, trajectory, lost)
    if stopped is None and slip_at is not None:  # a fall that began late is noticed only now
        cell.settle(WAIT_FOR_FALL / 4)
    if stopped is None and not is_lost(cell, grip):
        _arrive(cell, trajectory.positions[-1])
        return None
    fraction = 1.0 if stopped is None else stopped / len(trajectory)
    drop = Drop(grip.name, fraction, cell.finger_width(), slip_distance(cell, grip))
    if stopped is not None:
        _brake(cell, trajectory, stopped)
    return drop


def lower(cell: Cell, trajectory: Trajectory) -> int:
    """Drive down until something resists, and stay there; return the step of the trajectory.

    For a descent to a support of uncertain height. Contact shows in the joints' torques, which change
    slowly in free motion.
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


def open_hand(cell: Cell, opening: float) -> None:
    """Open the fingers, and wait until they stand still (a neighbour may stop them)."""
    cell.open_fingers(opening)
    _wait_for_fingers(cell)


def release(cell: Cell, opening: float) -> None:
    """Open gently until no pad presses, then wide: pads that spring back would move the body."""
    cell.open_fingers(cell.finger_width() / 2 + SPRING_BACK, PARTING_SPEED)
    cell.settle(SPRING_BACK / PARTING_SPEED)
    open_hand(cell, opening)


def close_hand(cell: Cell) -> None:
    """Close the fingers until they stand still."""
    cell.close_fingers()
    _wait_for_fingers(cell)
    cell.settle(0.05)


def _wait_for_fingers(cell: Cell) -> None:
    width = cell.finger_width()
    for _ in range(30):
        cell.settle(8 * TIME_STEP)
        before, width = width, cell.finger_width()
        if abs(width - before) < 2e-4:
            return


def _drive(cell: Cell, trajectory: Trajectory, ends: Callable[[int], bool]) -> int | None:
    """Drive along until `ends` is true of a step, and return that step, or None at the end.

    When a stop is requested, the arm brakes along the checked path and holds still with what it carries.
    """
    positions, velocities = trajectory.positions.tolist(), trajectory.velocities.tolist()
    try:
        for step, (position, velocity) in enumerate(zip(positions, velocities, strict=True)):
            cell.drive_arm(position, velocity)
            cell.step()
            if cell.stop_requested:
                _brake(cell, trajectory, step)
                fraction = (step + 1) / len(trajectory)
                raise KinematicsError(Reason.STOPPED, "a stop was requested", at_fraction=fraction)
            if ends(step):
                return step
    except KeyboardInterrupt:
        cell.hold()
        raise
    return None


def _brake(cell: Cell, trajectory: Trajectory, step: int) -> None:
    """Slow down along the planned path, which is the one that was checked."""
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


def _arrive(cell: Cell, goal: Array) -> None:
    """Wait for the joints to settle at the goal."""
    cell.drive_arm(goal.tolist(), [0.0] * len(goal))
    for _ in range(ARRIVAL_STEPS // 6):
        cell.settle(6 * TIME_STEP)
        error = float(np.abs(cell.joint_positions() - goal).max())
        if error < ARRIVED / 4:
            return
    if error > ARRIVED:
        cell.hold()
        raise KinematicsError(Reason.NOT_ARRIVED, f"a joint stopped {error:.4f} rad short", error=error)
