"""Global inverse kinematics: tool transforms in, joint positions out, by Levenberg-Marquardt with
restarts.
"""

import math
from collections.abc import Iterator

import numpy as np
import pinocchio

from kinematics import robot
from kinematics.geometry import Array

SOLVER = "pinocchio_lm"
POSITION_TOLERANCE = 1e-4  # [m]
ANGLE_TOLERANCE = 1e-3  # [rad]
MAXIMUM_ITERATIONS = 30
PATIENCE = 6  # iterations that do not halve the squared error
DAMPING = 0.01  # times the squared error


class InverseKinematics:
    """A Pinocchio model and its work space. Joint positions [rad], tool transforms to world."""

    def __init__(self) -> None:
        self._model = robot.pinocchio_model()
        self._data = self._model.createData()
        self._frame = self._model.getFrameId(robot.TOOL_FRAME)
        self._limits = robot.limits()

    def forward(self, q: Array) -> Array:
        """Transform of the tool to the world."""
        pinocchio.forwardKinematics(self._model, self._data, q)
        placement = pinocchio.updateFramePlacement(self._model, self._data, self._frame)
        return np.array(placement.homogeneous)

    def jacobian(self, q: Array) -> Array:
        """Twist of the tool, in the tool frame, per joint velocity: (6, 7), linear part first."""
        pinocchio.computeJointJacobians(self._model, self._data, q)
        pinocchio.updateFramePlacement(self._model, self._data, self._frame)
        return np.array(pinocchio.getFrameJacobian(self._model, self._data, self._frame, pinocchio.LOCAL))

    def solve(self, target: Array, start: Array) -> Array | None:
        """The solution that the iteration reaches from `start`, or None."""
        wanted = pinocchio.SE3(target)
        q = start.copy()
        before, stalled = math.inf, 0
        for _ in range(MAXIMUM_ITERATIONS):
            pinocchio.computeJointJacobians(self._model, self._data, q)
            placement = pinocchio.updateFramePlacement(self._model, self._data, self._frame)
            error = pinocchio.log6(placement.actInv(wanted)).vector  # (6,)
            if _is_small(error):
                return q
            squared = float(error @ error)
            stalled = stalled + 1 if squared > 0.5 * before else 0
            if stalled == PATIENCE:
                return None
            before = squared
            jacobian = pinocchio.getFrameJacobian(self._model, self._data, self._frame, pinocchio.LOCAL)
            q = self._step(q, jacobian, error, squared)
        return None

    def solutions(self, target: Array, starts: Iterator[Array]) -> Iterator[Array]:
        """Every distinct solution found from the starts, in their order."""
        found: list[Array] = []
        if np.linalg.norm(target[:3, 3] - robot.SHOULDER) > robot.REACH:
            return
        for start in starts:
            q = self.solve(target, start)
            if q is not None and all(np.abs(q - other).max() > 1e-2 for other in found):
                found.append(q)
                yield q

    def starts(self, target: Array, current: Array, seed: int, restarts: int) -> Iterator[Array]:
        """Where to start from: the usual posture, facing the target; here; then at random."""
        yield usual_posture(target)
        yield current
        generator = np.random.default_rng(seed)
        for _ in range(restarts):
            yield generator.uniform(self._limits.lower, self._limits.upper)

    def _step(self, q: Array, jacobian: Array, error: Array, squared: float) -> Array:
        normal = jacobian @ jacobian.T
        normal[np.diag_indices(6)] += DAMPING * squared + 1e-9
        step = jacobian.T @ np.linalg.solve(normal, error)
        largest = float(np.abs(step).max())
        if largest > 0.7:  # beyond this the linearisation says nothing
            step *= 0.7 / largest
        moved: Array = np.minimum(np.maximum(q + step, self._limits.lower), self._limits.upper)
        return moved


def usual_posture(target: Array) -> Array:
    """Elbow up, shoulder turned towards the target, the wrist turned as the target is."""
    q = robot.HOME.copy()
    q[0] = math.atan2(target[1, 3], target[0, 3])
    yaw = math.atan2(target[1, 0], target[0, 0])
    q[6] = math.remainder(robot.HOME[6] + q[0] - yaw, 2 * math.pi)
    limits = robot.limits()
    clipped: Array = np.clip(q, limits.lower, limits.upper)
    return clipped


def _is_small(error: Array) -> bool:
    linear, angular = error[:3], error[3:]
    return float(linear @ linear) < POSITION_TOLERANCE**2 and float(angular @ angular) < ANGLE_TOLERANCE**2


def usual_tool(x: float, y: float, z: float) -> Array:
    """Transform of a tool that points straight down, world frame [m]."""
    tool = np.diag([1.0, -1.0, -1.0, 1.0])
    tool[:3, 3] = x, y, z
    return tool
