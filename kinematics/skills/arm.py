"""What the arm knows of itself and of the cell: kinematics, collision scene and planner, as of the
last look.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from kinematics.collision.models import MARGIN
from kinematics.collision.scene import CollisionScene
from kinematics.geometry.transforms import Array, Pose, transform_of
from kinematics.ik.differential_ik import StraightLines
from kinematics.ik.global_ik import InverseKinematics
from kinematics.planning.planner import Path, Planner
from kinematics.robot.gripper import gripper_of
from kinematics.robot.robot import Robot
from kinematics.shapes.containers import load_of
from kinematics.simulation.workcell import Workcell

LINE_MARGIN = 0.002  # along a straight approach, where neighbours are near [m]


@dataclass(frozen=True)
class Look:
    """One observation of the cell; everything that a skill plans is planned from it."""

    q: Array  # (dof,) [rad]
    tool: Array  # (4, 4) transform to the world
    poses: dict[str, Pose]
    held: str | None
    opening: float  # of each finger [m]

    def tool_to(self, name: str) -> Array:
        """The body's transform to the tool."""
        rotation, position = self.tool[:3, :3], self.tool[:3, 3]
        body = transform_of(self.poses[name])
        body[:3, 3] = rotation.T @ (body[:3, 3] - position)
        body[:3, :3] = rotation.T @ body[:3, :3]
        return body


class Arm:
    """Solvers that are kept between motions, so that planning starts warm."""

    def __init__(self, robot: Robot) -> None:
        self.robot = robot
        self.gripper = gripper_of(robot)
        self.inverse = InverseKinematics(robot)
        self.lines = StraightLines(robot)
        self.planner = Planner(robot)
        self._scenes: dict[tuple[object, ...], CollisionScene] = {}
        self.scene = CollisionScene(robot, {})
        self.near: set[str] = set()  # what stood in the way since the last look

    def look(self, cell: Workcell) -> Look:
        """Measure the cell, and put everything in the collision scene where it is."""
        self.scene = self._scene(cell)
        limits = self.robot.limits  # a joint that rests at its limit is measured beyond it by a hair
        q: Array = np.clip(cell.joint_positions(), limits.lower, limits.upper)
        poses = cell.observed_poses()
        look = Look(q, self.inverse.forward(q), poses, cell.held(), cell.finger_width() / 2)
        self.near = set()
        self.scene.tolerate_nothing()
        self.scene.open_fingers(look.opening)
        self.show_held(look)
        return look

    def show_held(self, look: Look) -> None:
        """The scene as it is: the held body in the hand, and out of the way what lies in it."""
        if look.held is None:
            self.scene.place(look.poses)
            self.scene.hold(None)
        else:
            load = load_of(look.held, self.scene.shapes, look.poses)
            self.scene.place(look.poses, absent=frozenset([look.held, *load]))
            self.scene.hold(look.held, look.tool_to(look.held))

    def plan(self, start: Array, goal: Array, seed: int) -> Path:
        """A path with `MARGIN` around everything but what is touched at the start."""
        scene = self.scene
        scene.tolerate_here(start)
        try:
            return self.planner.plan(start, goal, scene.is_free, seed)
        finally:
            scene.tolerate_nothing()

    def chain_is_free(self, chain: Array, margin: float = LINE_MARGIN) -> bool:
        """Whether every point of a dense chain keeps the margin."""
        return all(self.scene.is_free(q, margin) for q in chain)

    def solutions(self, target: Array, current: Array, seed: int, restarts: int) -> Iterator[Array]:
        """Joint positions for a tool transform that touch nothing, the usual posture first."""
        starts = self.inverse.starts(target, current, seed, restarts)
        for q in self.inverse.solutions(target, starts):
            if self.scene.is_free(q, MARGIN):
                yield q
            else:
                self.near.update(*(touch.names for touch in self.scene.touches(q)))

    def _scene(self, cell: Workcell) -> CollisionScene:
        shapes = {name: body.shape for name, body in cell.bodies.items()}
        fixed = frozenset(name for name, body in cell.bodies.items() if body.is_fixed)
        key = (*shapes.items(), fixed)
        if key not in self._scenes:
            if len(self._scenes) >= 8:
                self._scenes.clear()
            self._scenes[key] = CollisionScene(self.robot, shapes, fixed)
        return self._scenes[key]


def travel(a: Array, b: Array) -> float:
    """How far apart two configurations are for the slowest joint [rad]."""
    return float(np.abs(a - b).max())
