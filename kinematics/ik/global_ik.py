"""From tool transforms to joint positions: Levenberg-Marquardt with restarts."""

import math
from collections.abc import Iterator
from functools import cache

import numpy as np
import pinocchio
from scipy.linalg.lapack import dposv

from kinematics.geometry.transforms import Array, check_transform
from kinematics.ik.seed_postures import SeedPostures
from kinematics.robot import models
from kinematics.robot.robot import Robot

SOLVER = "pinocchio_lm"
POSITION_TOLERANCE = 1e-4  # [m]
ANGLE_TOLERANCE = 1e-3  # [rad]
MAXIMUM_ITERATIONS = 30
PATIENCE = 4  # iterations in a row that fail to halve the squared error
LARGEST_STEP = 0.7  # of a joint; beyond, the linearisation is invalid [rad]
POSTURES = 20_000  # random ones, kept as seeds
NEIGHBOURS = 12  # kept postures to start from, before random ones
FIRST = 3  # of these are looked up first, since one of them nearly always serves
SIMILAR_APPROACH = math.cos(1.0)  # to that at home: then the posture that faces the target is a good start
DAMPING = 0.01  # times the squared error


class InverseKinematics:
    """A Pinocchio model with its data. Joint positions in rad, tool transforms to the world (4, 4)."""

    def __init__(self, robot: Robot) -> None:
        self.robot = robot
        self._model = models.pinocchio_model(robot)
        self._data = self._model.createData()
        self._frame = self._model.getFrameId(robot.tool_frame)
        self._limits = robot.limits
        self._shoulder, self._reach = self._measure_reach()
        self._home_jacobian = self._world_jacobian(robot.home)
        self._home_tool = self.forward(robot.home)

    def forward(self, q: Array) -> Array:
        """Return the transform of the tool to the world (4, 4)."""
        pinocchio.forwardKinematics(self._model, self._data, q)
        placement = pinocchio.updateFramePlacement(self._model, self._data, self._frame)
        return np.array(placement.homogeneous)

    def jacobian(self, q: Array) -> Array:
        """Return the tool's twist per joint velocity (6, dof), in the tool frame, linear part first."""
        pinocchio.computeJointJacobians(self._model, self._data, q)
        pinocchio.updateFramePlacement(self._model, self._data, self._frame)
        return np.array(pinocchio.getFrameJacobian(self._model, self._data, self._frame, pinocchio.LOCAL))

    def solve(self, target: Array, start: Array) -> Array | None:
        """Return the solution that the iteration reaches from `start`, or None.

        Raise `UnusablePose` for a target that is no transform.
        """
        check_transform("the tool", target)
        return self._iterate(target, start)

    def _iterate(self, target: Array, start: Array) -> Array | None:
        model, data, frame = self._model, self._data, self._frame
        wanted = pinocchio.SE3(target)
        q = start
        before, stalled = math.inf, 0
        for _ in range(MAXIMUM_ITERATIONS):
            pinocchio.computeJointJacobians(model, data, q)
            placement = pinocchio.updateFramePlacement(model, data, frame)
            error = pinocchio.log6(placement.actInv(wanted)).vector  # (6,)
            x, y, z, u, v, w = error.tolist()
            linear, angular = x * x + y * y + z * z, u * u + v * v + w * w
            if linear < POSITION_TOLERANCE**2 and angular < ANGLE_TOLERANCE**2:
                return q
            squared = linear + angular
            stalled = stalled + 1 if squared > 0.5 * before else 0
            if stalled == PATIENCE:
                return None
            before = squared
            jacobian = pinocchio.getFrameJacobian(model, data, frame, pinocchio.LOCAL)
            q = self._step(q, jacobian, error, squared)
        return None

    def solutions(self, target: Array, starts: Iterator[Array]) -> Iterator[Array]:
        """Yield every distinct solution found from the starts, in their order.

        Raise `UnusablePose` for a target that is no transform.
        """
        found: list[Array] = []
        check_transform("the tool", target)
        if math.dist(target[:3, 3], self._shoulder) > self._reach:
            return
        for start in starts:
            q = self._iterate(target, start)
            if q is not None and all(np.abs(q - other).max() > 1e-2 for other in found):
                found.append(q)
                yield q

    def starts(self, target: Array, current: Array, seed: int, restarts: int) -> Iterator[Array]:
        """Yield joint positions to start from.

        A posture facing the target, the current one, kept ones with the tool near the target, random ones.

        Args:
            restarts: number of the last two kinds.
        """
        if not restarts or float(target[:3, 2] @ self._home_tool[:3, 2]) > SIMILAR_APPROACH:
            yield self.posture_facing(target)
            yield current
        near = min(NEIGHBOURS, restarts)
        if near:
            yield from _postures_of(self.robot).near(target, FIRST)[:near]
        if near > FIRST:
            yield from _postures_of(self.robot).near(target, near)[FIRST:]
        generator = np.random.default_rng(seed)
        for _ in range(restarts - near):
            yield generator.uniform(self._limits.lower, self._limits.upper)

    def posture_facing(self, target: Array) -> Array:
        """Return the home posture with the shoulder turned to face the target, and the wrist to its yaw.

        A first or last joint whose axis is not vertical at home keeps its position.
        """
        q = self.robot.home.copy()
        first, last = self._home_jacobian[5, 0], self._home_jacobian[5, -1]
        home = self._home_tool
        turned = 0.0
        if abs(first) > 0.9:
            turned = self._bearing(target) - self._bearing(home)
            q[0] += math.copysign(turned, first * turned)
        if abs(last) > 0.9:
            yaw = math.atan2(target[1, 0], target[0, 0]) - math.atan2(home[1, 0], home[0, 0]) - turned
            q[-1] += math.remainder(math.copysign(1.0, last) * yaw, 2 * math.pi)
        clipped: Array = np.clip(q, self._limits.lower, self._limits.upper)
        return clipped

    def _bearing(self, tool: Array) -> float:
        """Return the bearing of a tool as seen from the shoulder [rad]."""
        x, y, _ = (tool[:3, 3] - self._shoulder).tolist()
        return math.atan2(y, x)

    def _world_jacobian(self, q: Array) -> Array:
        pinocchio.computeJointJacobians(self._model, self._data, q)
        pinocchio.updateFramePlacement(self._model, self._data, self._frame)
        aligned = pinocchio.LOCAL_WORLD_ALIGNED
        return np.array(pinocchio.getFrameJacobian(self._model, self._data, self._frame, aligned))

    def _measure_reach(self) -> tuple[Array, float]:
        """Return the position of the first joint, and the tool's largest distance from there [m]."""
        model = self._model
        placements = [model.jointPlacements[k].translation for k in range(2, model.njoints)]
        tool = model.frames[self._frame].placement.translation
        shoulder = np.array(model.jointPlacements[1].translation)
        return shoulder, sum(float(np.linalg.norm(way)) for way in (*placements, tool)) + 1e-3

    def _step(self, q: Array, jacobian: Array, error: Array, squared: float) -> Array:
        lower, upper = self._limits.lower, self._limits.upper
        damping = DAMPING * squared + 1e-9
        moved = q + _shortened(_least_squares(jacobian, error, damping))
        within: Array = np.minimum(np.maximum(moved, lower), upper)
        if (within != moved).any():
            stuck = within == q
            if stuck.any():  # joints at their limit cannot contribute
                jacobian[:, stuck] = 0.0
                moved = q + _shortened(_least_squares(jacobian, error, damping))
                within = np.minimum(np.maximum(moved, lower), upper)
        return within


def _shortened(step: Array) -> Array:
    """Scale a step so that no joint moves farther than `LARGEST_STEP`."""
    largest = max(map(abs, step.tolist()))
    return step if largest <= LARGEST_STEP else step * (LARGEST_STEP / largest)


def _least_squares(jacobian: Array, error: Array, damping: float) -> Array:
    normal = jacobian @ jacobian.T
    normal.flat[::7] += damping
    step: Array = jacobian.T @ dposv(normal, error)[1]
    return step


@cache
def _postures_of(robot: Robot) -> SeedPostures:
    """Return the seeds of a robot, made once a process in a tenth of a second."""
    solver, limits = InverseKinematics(robot), robot.limits
    joints = np.random.default_rng(0).uniform(limits.lower, limits.upper, (POSTURES, robot.dof))
    return SeedPostures(joints, np.array([solver.forward(q) for q in joints]))


def tool_pointing_down(x: float, y: float, z: float) -> Array:
    """Return the transform of a tool that points straight down, world frame [m]."""
    tool = np.diag([1.0, -1.0, -1.0, 1.0])
    tool[:3, 3] = x, y, z
    return tool
