"""From a chain of joint positions to positions and velocities at every control step.

Corners are rounded, then the path is followed as fast as the joints' velocities and accelerations and
the tool's speed allow: a forward and a backward pass over the path, as in time-optimal path
parameterisation. A moving average of the distance along the path then bounds the jerk; it changes the
timing, never the path.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from kinematics.geometry.transforms import Array
from kinematics.robot.robot import Limits

TIME_STEP = 1 / 240  # of control and simulation [s]
VELOCITY_SHARE = 0.9  # of the joints' limits
ACCELERATION_SHARE = 0.5
SMOOTHING = 6  # control steps over which an acceleration builds up
PATH_SPACING = 0.02  # of points along the path, Euclidean over the joints [rad]
ROUNDING = 0.3  # distance from a corner at which its curve begins, at most [rad]
SMALLEST_ROUNDING = 0.01  # [rad]


@dataclass(frozen=True)
class Trajectory:
    """Set points of the arm, one per control step."""

    positions: Array  # (n, dof) [rad]
    velocities: Array  # (n, dof) [rad/s]

    def __len__(self) -> int:
        return len(self.positions)

    @property
    def duration(self) -> float:
        """Duration [s]."""
        return len(self) * TIME_STEP

    def reversed(self) -> "Trajectory":
        """Return the same path at the same speeds, backwards."""
        return Trajectory(self.positions[::-1].copy(), -self.velocities[::-1])


def round_corners(corners: Array, free: Callable[[Array], bool]) -> Array:
    """Replace each corner by a parabola, as wide as obstacles allow; return dense points (n, dof)."""
    points = [corners[:1]]
    for before, corner, after in zip(corners, corners[1:], corners[2:], strict=False):
        points.append(_rounded(before, corner, after, free))
    points.append(corners[-1:])
    return np.concatenate(points)


def _rounded(before: Array, corner: Array, after: Array, free: Callable[[Array], bool]) -> Array:
    into, out = before - corner, after - corner
    lengths = float(np.linalg.norm(into)), float(np.linalg.norm(out))
    reach = min(ROUNDING, lengths[0] / 2, lengths[1] / 2)
    t = np.linspace(0, 1, 12)[:, None]
    while True:
        a, b = corner + into * (reach / lengths[0]), corner + out * (reach / lengths[1])
        curve: Array = (1 - t) ** 2 * a + 2 * t * (1 - t) * corner + t**2 * b  # (12, dof)
        if reach < SMALLEST_ROUNDING or free(curve):
            return curve
        reach /= 2


def time_parameterise(
    chain: Array, limits: Limits, tool_speed: float = math.inf, tool_length: float = 0.0
) -> Trajectory:
    """Return the fastest motion along a chain, from rest to rest.

    Args:
        tool_speed: maximum speed of the tool [m/s], on a chain whose points are equally far apart for it.
        tool_length: distance of the tool along the chain [m].
    """
    path = _resampled(chain)
    steps = np.linalg.norm(np.diff(path, axis=0), axis=1)  # (n-1,)
    if len(path) < 2 or float(steps.sum()) < 1e-6:
        return Trajectory(chain[-1:].copy(), np.zeros((1, chain.shape[1])))
    s = np.concatenate([[0.0], np.cumsum(steps)])
    tangent = np.gradient(path, s, axis=0)  # dq/ds
    bend = _widest(np.abs(np.gradient(tangent, s, axis=0)))  # |d2q/ds2|
    highest = _speed_limits(tangent, bend, limits)
    if tool_length > 0:
        highest = np.minimum(highest, tool_speed * s[-1] / tool_length)
    speed = _passes(s, highest, _tangential_acceleration(tangent, bend, highest, limits))
    return _sampled(s, path, tangent, speed)


def _resampled(chain: Array) -> Array:
    """Return points equally spaced along the chain, which keeps finite differences well-behaved."""
    steps = np.linalg.norm(np.diff(chain, axis=0), axis=1)
    s = np.concatenate([[0.0], np.cumsum(steps)])
    keep = np.concatenate([[True], steps > 1e-9])
    points = max(12, math.ceil(float(s[-1]) / PATH_SPACING)) + 1
    even = np.linspace(0.0, s[-1], points)
    return np.stack([np.interp(even, s[keep], column[keep]) for column in chain.T], axis=1)


def _widest(bend: Array) -> Array:
    """Return the largest value of each point and its neighbours, since a bend begins between two points."""
    padded = np.pad(bend, ((1, 1), (0, 0)), mode="edge")
    widest: Array = np.maximum(np.maximum(padded[:-2], padded[1:-1]), padded[2:])
    return widest


def _speed_limits(tangent: Array, bend: Array, limits: Limits) -> Array:
    """Return the highest path speed at every point, with half the acceleration reserved for bends."""
    by_velocity = (VELOCITY_SHARE * limits.velocity / (np.abs(tangent) + 1e-9)).min(axis=1)
    acceleration = ACCELERATION_SHARE * limits.acceleration
    by_bend = np.sqrt((0.5 * acceleration / (bend + 1e-9)).min(axis=1))
    limit: Array = np.minimum(by_velocity, by_bend)
    return limit


def _tangential_acceleration(tangent: Array, bend: Array, highest: Array, limits: Limits) -> Array:
    """Return what the bend, at the highest speed, leaves for speeding up and slowing down [rad/s2]."""
    left = ACCELERATION_SHARE * limits.acceleration - bend * highest[:, None] ** 2
    along: Array = (left / (np.abs(tangent) + 1e-9)).min(axis=1)
    return along


def _passes(s: Array, highest: Array, acceleration: Array) -> Array:
    """Limit speeds in a forward and a backward pass to what the acceleration allows."""
    squared = (highest**2).tolist()
    gain = (2 * np.minimum(acceleration[1:], acceleration[:-1]) * np.diff(s)).tolist()
    squared[0] = squared[-1] = 0.0
    for i in range(1, len(squared)):
        squared[i] = min(squared[i], squared[i - 1] + gain[i - 1])
    for i in range(len(squared) - 2, -1, -1):
        squared[i] = min(squared[i], squared[i + 1] + gain[i])
    speed: Array = np.sqrt(np.array(squared))
    return speed


def _sampled(s: Array, path: Array, tangent: Array, speed: Array) -> Trajectory:
    """Return set points at every control step; between path points the acceleration is constant."""
    between = 2 * np.diff(s) / (speed[1:] + speed[:-1])
    times = np.concatenate([[0.0], np.cumsum(between)])
    count = max(1, math.ceil(float(times[-1]) / TIME_STEP))
    t = np.minimum(np.arange(1, count + 1) * TIME_STEP, times[-1])
    i = np.clip(np.searchsorted(times, t, side="right") - 1, 0, len(between) - 1)
    within = t - times[i]
    acceleration = (speed[i + 1] - speed[i]) / between[i]
    along = s[i] + speed[i] * within + 0.5 * acceleration * within**2
    rate = speed[i] + acceleration * within
    along, rate = _averaged(along, s[0], s[-1]), _averaged(rate, 0.0, 0.0)
    i = np.clip(np.searchsorted(s, along, side="right") - 1, 0, len(s) - 2)
    positions, directions = _hermite(path, tangent, s, i, along)
    velocities = directions * rate[:, None]
    positions[-1], velocities[-1] = path[-1], 0.0
    return Trajectory(positions, velocities)


def _averaged(values: Array, before: float, after: float) -> Array:
    """Return the moving average over `SMOOTHING` control steps, continued until it is at rest."""
    rest = SMOOTHING - 1
    padded = np.concatenate([np.full(rest, before), values, np.full(rest, after)])
    sums = np.cumsum(np.concatenate([[0.0], padded]))
    averaged: Array = (sums[SMOOTHING:] - sums[:-SMOOTHING]) / SMOOTHING
    return averaged


def _hermite(path: Array, tangent: Array, s: Array, i: Any, along: Array) -> tuple[Array, Array]:
    """Return points and derivatives of the cubic Hermite spline, whose direction is continuous."""
    length = (s[i + 1] - s[i])[:, None]
    u = (along - s[i])[:, None] / length
    a, b, da, db = path[i], path[i + 1], tangent[i] * length, tangent[i + 1] * length
    points = (
        (1 + 2 * u) * (1 - u) ** 2 * a + u * (1 - u) ** 2 * da + u**2 * (3 - 2 * u) * b + u**2 * (u - 1) * db
    )
    slope = (6 * u * (u - 1) * (a - b) + (1 - u) * (1 - 3 * u) * da + u * (3 * u - 2) * db) / length
    return points, slope
