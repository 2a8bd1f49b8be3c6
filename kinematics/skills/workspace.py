"""From an arm to its workspace: the part of the table over which its tool can point straight down.

Given in the arm's TOML, or measured: from the table to some height, at every yaw, by joint positions that
touch neither the arm itself nor the table.
"""

import itertools
import math
from dataclasses import dataclass
from functools import cache

from kinematics.collision.scene import CollisionScene
from kinematics.collision.scene_state import SceneState
from kinematics.errors import UnusableRobot
from kinematics.geometry.transforms import Z_AXIS, rotation_about
from kinematics.ik.global_ik import InverseKinematics, tool_pointing_down
from kinematics.robot.gripper import gripper_of
from kinematics.robot.robot import Region, Robot

FLOOR = 0.02  # of the tool [m]
CEILINGS = (0.4, 0.3, 0.2)  # of the tool; the first with enough room counts [m]
HALF_WIDTHS = (0.2, 0.15, 0.1)  # along y, widest first [m]
NEAREST, FARTHEST, STEP = 0.15, 1.2, 0.05  # along x from the world's origin [m]
LEAST_DEPTH = 0.15  # along x [m]
WORKSPACE_YAWS = [math.pi * k / 6 for k in range(6)]  # the other half turn swaps the fingers
WORKSPACE_RESTARTS = 12  # of inverse kinematics, per tool pose


@dataclass(frozen=True)
class Workspace:
    """Where objects may be, and the height that the tool reaches everywhere over them."""

    region: Region  # of x and of y, world frame [m]
    ceiling: float  # of the tool [m]


@cache
def workspace_of(robot: Robot) -> Workspace:
    """Return the workspace of the TOML, or measure it in a few tenths of a second."""
    if robot.workspace is not None:
        return Workspace(robot.workspace, CEILINGS[0])
    reach = _Reach(robot)
    middles = dict.fromkeys((0.0, round(reach.home_y / STEP) * STEP))  # the base may be to one side
    for ceiling, half_width, middle in itertools.product(CEILINGS, HALF_WIDTHS, middles):
        sides = (round(middle - half_width, 3), round(middle + half_width, 3))
        near, far = reach.longest(sides, ceiling)
        if far - near >= LEAST_DEPTH - 1e-9:
            return Workspace(((near, far), sides), ceiling)
    raise UnusableRobot(
        f"{robot.name}: nowhere in front of the arm, {NEAREST} to {FARTHEST} m along x, can its tool point "
        "down at every yaw; check 'approach' and 'home', or give the `workspace`"
    )


class _Reach:
    def __init__(self, robot: Robot) -> None:
        self._robot = robot
        self._solver = InverseKinematics(robot)
        self._scene = CollisionScene(robot, {})
        self._state = SceneState({}, gripper_of(robot).maximum_opening)

    @property
    def home_y(self) -> float:
        """Position of the tool at home, along y [m]."""
        return float(self._solver.forward(self._robot.home)[1, 3])

    def longest(self, sides: tuple[float, float], ceiling: float) -> tuple[float, float]:
        """Return the longest interval of x in which every row is within reach [m]."""
        best = start = end = NEAREST
        for k in range(1 + round((FARTHEST - NEAREST) / STEP)):
            x = round(NEAREST + k * STEP, 3)
            if not self._has_row(x, sides, ceiling):
                start = x + STEP
            elif x - start > end - best:
                best, end = start, x
        return round(best, 3), end

    def _has_row(self, x: float, sides: tuple[float, float], ceiling: float) -> bool:
        corners = itertools.product((sides[0], sum(sides) / 2, sides[1]), (FLOOR, ceiling), WORKSPACE_YAWS)
        return all(
            self._reaches(x, y, z, yaw) or self._reaches(x, y, z, yaw + math.pi) for y, z, yaw in corners
        )

    def _reaches(self, x: float, y: float, z: float, yaw: float) -> bool:
        tool = tool_pointing_down(x, y, z)
        tool[:3, :3] = rotation_about(Z_AXIS, yaw) @ tool[:3, :3]
        starts = self._solver.starts(tool, self._robot.home, 0, WORKSPACE_RESTARTS)
        return any(self._scene.is_free(q, self._state) for q in self._solver.solutions(tool, starts))
