"""From a straight line of the tool to a chain of joint positions: differential inverse kinematics by mink."""

import math

import mink
import numpy as np

from kinematics.geometry.transforms import (
    Array,
    check_finite,
    check_transform,
    quaternion_from_rotation,
    wxyz,
)
from kinematics.robot import models
from kinematics.robot.robot import Robot

SOLVER = "mink_daqp"
LINE_SPACING = 0.01  # between the points of a line [m]
ERROR_TOLERANCE = 2e-4  # [m] and [rad]
STEPS_PER_POINT = 5
LARGEST_JUMP = 0.35  # of a joint between two points; more means that the arm folds over [rad]


class StraightLines:
    """A mink configuration and task, kept between lines."""

    def __init__(self, robot: Robot) -> None:
        model = models.mujoco_model(robot)
        self._frame = robot.tool_frame
        self._configuration = mink.Configuration(model)
        self._limits = [mink.ConfigurationLimit(model)]
        self._task = mink.FrameTask(self._frame, "body", position_cost=1.0, orientation_cost=1.0)

    def follow(self, start: Array, corners: list[Array]) -> Array | None:
        """Return joint positions (n, dof) that lead the tool from `start` through the corner transforms.

        The orientation is that of the next corner (corners of one line differ little). None if the line
        leaves the joint limits or the arm would have to fold over. Raise `UnusablePose` for a corner that is
        no transform.
        """
        check_finite("the start of the line", *start.tolist())
        for corner in corners:
            check_transform("a corner of the line", corner)
        self._configuration.update(start)
        tool = self._configuration.get_transform_frame_to_world(self._frame, "body")
        here = np.asarray(tool.translation())
        chain = [start]
        for corner in corners:
            there = corner[:3, 3]
            points = max(1, math.ceil(float(np.linalg.norm(there - here)) / LINE_SPACING - 1e-6))
            for k in range(1, points + 1):
                q = self._reach(corner[:3, :3], here + (there - here) * (k / points))
                if q is None or np.abs(q - chain[-1]).max() > LARGEST_JUMP:
                    return None
                chain.append(q)
            here = there
        return np.array(chain)

    def _reach(self, rotation: Array, position: Array) -> Array | None:
        target = mink.SE3.from_rotation_and_translation(
            mink.SO3(np.array(wxyz(quaternion_from_rotation(rotation)))), position
        )
        self._task.set_target(target)
        for _ in range(STEPS_PER_POINT):
            try:
                velocity = mink.solve_ik(
                    self._configuration,
                    [self._task],
                    1.0,
                    solver="daqp",
                    damping=1e-9,
                    limits=self._limits,
                )
            except mink.NoSolutionFound:
                return None
            self._configuration.integrate_inplace(velocity, 1.0)
            error = self._task.compute_error(self._configuration)
            if float(error @ error) < ERROR_TOLERANCE**2:
                return np.array(self._configuration.q)
        return None
