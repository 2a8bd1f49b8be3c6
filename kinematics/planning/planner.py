"""From start and goal joint positions to a collision-free chain of joint positions.

The straight edge is tried first; it is free in about half of all queries. The limit of a search is a number
of validity checks, never wall time, so a busy machine changes no path and no failure.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
from ompl import base, geometric, util

from kinematics.collision.models import lever_arms
from kinematics.errors import NoPathFound, Obstructed, Reason, UnusablePose
from kinematics.geometry.transforms import Array
from kinematics.robot.robot import Robot

RESOLUTION = 1 / 32  # between two checks by OMPL, Euclidean over the joints [rad]
RANGE = 1.0  # of one extension of a tree [rad]
MAXIMUM_CHECKS = 20_000
MAXIMUM_ROUNDS = 100_000  # of a planner's loop, since LBKPIECE grows its trees without checking
AT_LIMIT = 1e-6  # a position this far beyond a joint's limit counts as at the limit [rad]
SHORTCUTS = 20
HELD_REACH = 0.15  # of a held body from the axis of the last joint, at most [m]

Validity = Callable[[Array], bool]  # of joint positions; deterministic


@dataclass(frozen=True)
class Path:
    """A chain of joint positions whose every edge was checked."""

    corners: Array  # (n, dof) [rad]
    planner: str
    checks: int


class Planner:
    """An OMPL set-up, kept since a new one per query would leak memory."""

    def __init__(self, robot: Robot) -> None:
        util.setLogLevel(util.LOG_NONE)
        self._limits = limits = robot.limits
        self._dof = robot.dof
        levers = np.maximum(lever_arms(robot), HELD_REACH)
        self._steps_per_joint = levers / (levers.max() * RESOLUTION)  # (dof,) [1/rad]
        bounds = base.RealVectorBounds(robot.dof)
        for joint in range(robot.dof):
            bounds.setLow(joint, float(limits.lower[joint]))
            bounds.setHigh(joint, float(limits.upper[joint]))
        self._space = base.RealVectorStateSpace(robot.dof)
        self._space.setBounds(bounds)
        self._setup = geometric.SimpleSetup(self._space)
        self._setup.setStateValidityChecker(self._is_valid)
        self._information = self._setup.getSpaceInformation()
        self._information.setStateValidityCheckingResolution(RESOLUTION / self._space.getMaximumExtent())
        self._setup.setPlanner(_rrt_connect(self._information))
        self._setup.setup()  # its first call draws random numbers, which must not happen within a query
        self._valid: Validity = lambda q: True
        self._checks = self._rounds = 0

    def plan(
        self, start: Array, goal: Array, valid: Validity, seed: int, planner: str = "rrt_connect"
    ) -> Path:
        """Return a checked path; raise `UnusablePose`, `Obstructed` or `NoPathFound`."""
        if planner not in PLANNERS:
            raise ValueError(f"no planner is called '{planner}'; there are {', '.join(PLANNERS)}")
        make = PLANNERS[planner]
        self._valid, self._checks, self._rounds = valid, 0, 0
        start = self._checked_end(start, "start", Reason.START_IN_COLLISION)
        goal = self._checked_end(goal, "goal", Reason.GOAL_IN_COLLISION)
        if self._edge_is_free(start, goal):
            return Path(np.array([start, goal]), "straight", self._checks)
        corners = self._search(start, goal, make, seed)
        shortened = self._shorten(corners, np.random.default_rng(seed))
        return Path(np.array(shortened), planner, self._checks)

    def _checked_end(self, q: Array, end: str, in_collision: Reason) -> Array:
        """Return a valid end of a motion, clipped: for a goal just outside its bounds OMPL waits for ever."""
        if not self._limits.contains(q, AT_LIMIT):
            raise UnusablePose(f"the {end} of the motion", f"{q} is not within the limits of the joints")
        clipped: Array = np.minimum(np.maximum(q, self._limits.lower), self._limits.upper)
        if not self._check(clipped):
            raise Obstructed(in_collision, f"the {end} of the motion is in collision")
        return clipped

    def _search(self, start: Array, goal: Array, make: Callable[[Any], Any], seed: int) -> list[Array]:
        util.RNG.setSeed(seed % (2**31 - 1) + 1)
        setup = self._setup
        setup.clear()
        setup.setPlanner(make(self._information))  # a planner that is kept does not repeat its path
        setup.setStartAndGoalStates(self._state(start), self._state(goal))
        setup.solve(base.PlannerTerminationCondition(self._is_exhausted))
        if not setup.haveExactSolutionPath():
            raise self._no_path()
        states = setup.getSolutionPath().getStates()
        corners = [np.array(state[0 : self._dof]) for state in states]
        if np.abs(corners[0] - start).max() > 1e-6 or np.abs(corners[-1] - goal).max() > 1e-6:
            raise self._no_path()
        return corners

    def _no_path(self) -> NoPathFound:
        message = f"no path after {self._checks} validity checks"
        return NoPathFound(Reason.NO_PATH, message, checks=self._checks)

    def _shorten(self, corners: list[Array], generator: np.random.Generator) -> list[Array]:
        """Replace parts of the chain between two random points by free straight edges."""
        corners = self._without_redundant(corners)
        for _ in range(SHORTCUTS):
            if len(corners) <= 2:
                break
            first, second = sorted(generator.uniform(0, len(corners) - 1, 2))
            if int(first) == int(second):
                continue
            a, b = _point(corners, first), _point(corners, second)
            if self._edge_is_free(a, b):
                corners = [*corners[: int(first) + 1], a, b, *corners[int(second) + 1 :]]
                corners = _without_repeats(corners)
        return self._without_redundant(corners)

    def _without_redundant(self, corners: list[Array]) -> list[Array]:
        """Return the chain without corners that free straight edges skip."""
        kept = [corners[0]]
        i = 0
        while i < len(corners) - 1:
            farthest = len(corners) - 1
            while farthest > i + 1 and not self._edge_is_free(corners[i], corners[farthest]):
                farthest -= 1
            kept.append(corners[farthest])
            i = farthest
        return kept

    def _edge_is_free(self, a: Array, b: Array) -> bool:
        """Check an edge in steps of equal displacement.

        Between two checks no point of the arm moves farther than the joint with the longest lever arm would
        move it in a step of `RESOLUTION`, so a turn of the wrist needs few checks.
        """
        way = b - a
        steps = max(1, math.ceil(float(np.abs(way) @ self._steps_per_joint)))
        points = a + _bisecting(steps)[:, None] * way
        return all(map(self._check, points))

    def _check(self, q: Array) -> bool:
        self._checks += 1
        return self._valid(q)

    def _is_valid(self, state: Any) -> bool:
        return bool(self._check(np.array(state[0 : self._dof])))  # OMPL takes no bool of numpy's

    def _is_exhausted(self) -> bool:
        self._rounds += 1
        return self._checks >= MAXIMUM_CHECKS or self._rounds >= MAXIMUM_ROUNDS

    def _state(self, q: Array) -> Any:
        state = self._space.allocState()
        for joint in range(self._dof):
            state[joint] = float(q[joint])
        return state


@lru_cache(maxsize=1024)
def _bisecting(steps: int) -> Array:
    """Return 1/steps … 1, coarsely spaced fractions first, since an obstacle is rarely at an end."""
    stride = 1 << max(0, steps.bit_length() - 1)
    order: dict[int, None] = {}
    while stride:
        order |= dict.fromkeys(range(stride, steps + 1, stride))
        stride //= 2
    return np.array(list(order)) / steps


def _point(corners: list[Array], at: float) -> Array:
    i = min(int(at), len(corners) - 2)
    return corners[i] + (corners[i + 1] - corners[i]) * (at - i)


def _without_repeats(corners: list[Array]) -> list[Array]:
    kept = [corners[0]]
    for corner in corners[1:]:
        if float(np.abs(corner - kept[-1]).max()) > 1e-9:
            kept.append(corner)
    return kept


def _rrt_connect(information: Any) -> Any:
    planner = geometric.RRTConnect(information)
    planner.setRange(RANGE)
    return planner


def _bkpiece(information: Any) -> Any:
    planner = geometric.BKPIECE1(information)
    planner.setRange(RANGE)
    return planner


def _lbkpiece(information: Any) -> Any:
    planner = geometric.LBKPIECE1(information)
    planner.setRange(RANGE)
    return planner


PLANNERS: dict[str, Callable[[Any], Any]] = {
    "rrt_connect": _rrt_connect,
    "bkpiece": _bkpiece,
    "lbkpiece": _lbkpiece,
}
