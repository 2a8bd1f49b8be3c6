"""The arm's solvers (kinematics, collision, planning), and the snapshot of the cell that they plan from."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from kinematics.collision.models import MARGIN
from kinematics.collision.scene import CollisionScene
from kinematics.collision.scene_state import HeldBody, SceneState
from kinematics.geometry.transforms import Array, Pose, pose_of, transform_of
from kinematics.ik.differential_ik import StraightLines
from kinematics.ik.global_ik import InverseKinematics
from kinematics.planning.planner import Path, Planner
from kinematics.robot.gripper import gripper_of
from kinematics.robot.robot import Robot
from kinematics.shapes.containers import contents_of
from kinematics.simulation.cell import Cell

LINE_MARGIN = 0.002  # along a straight approach, with neighbours near [m]


@dataclass(frozen=True)
class CellSnapshot:
    """One observation of the cell, from which skills plan."""

    q: Array  # (dof,) [rad]
    tool: Array  # (4, 4) transform to the world
    state: SceneState  # of the collision scene, as observed

    @property
    def poses(self) -> Mapping[str, Pose]:
        """Poses of all bodies, world frame."""
        return self.state.poses

    @property
    def held(self) -> str | None:
        """Name of the held body."""
        return None if self.state.held is None else self.state.held.name

    @property
    def opening(self) -> float:
        """Opening of each finger [m]."""
        return self.state.opening

    def body_to_tool(self, name: str) -> Array:
        """Return the body's transform to the tool (4, 4)."""
        return _to_tool(self.poses[name], self.tool)


class Arm:
    """Solvers, kept between motions so that planning starts warm."""

    def __init__(self, robot: Robot) -> None:
        self.robot = robot
        self.gripper = gripper_of(robot)
        self.inverse = InverseKinematics(robot)
        self.lines = StraightLines(robot)
        self.planner = Planner(robot)
        self._scenes: dict[tuple[object, ...], CollisionScene] = {}
        self.scene = CollisionScene(robot, {})
        self.near: set[str] = set()  # names of what stood in the way since the last snapshot

    def observe(self, cell: Cell) -> CellSnapshot:
        """Return a snapshot of the cell, and take up the collision scene of its bodies."""
        self.scene = self._scene(cell)
        self.near = set()
        limits = self.robot.limits  # a joint at rest at its limit is measured slightly beyond it
        q: Array = np.clip(cell.joint_positions(), limits.lower, limits.upper)
        tool, poses, held = self.inverse.forward(q), cell.observed_poses(), cell.held()
        state = SceneState(poses, cell.finger_width() / 2)
        if held is not None:
            pose_in_tool = pose_of(_to_tool(poses[held], tool))
            load = contents_of(held, self.scene.shapes, poses)
            state = state.with_held(HeldBody(held, pose_in_tool), load)
        return CellSnapshot(q, tool, state)

    def plan(self, start: Array, goal: Array, state: SceneState, seed: int) -> Path:
        """Return a path that keeps `MARGIN` from everything that is not nearer at the start already."""
        scene, tolerating = self.scene, self.scene.tolerating(start, state)
        return self.planner.plan(start, goal, lambda q: scene.is_free(q, tolerating), seed)

    def chain_is_free(self, chain: Array, state: SceneState, margin: float = LINE_MARGIN) -> bool:
        """Return whether every point of a dense chain keeps the margin [m]."""
        return all(self.scene.is_free(q, state, margin) for q in chain)

    def solutions(
        self, target: Array, current: Array, state: SceneState, seed: int, restarts: int
    ) -> Iterator[Array]:
        """Yield joint positions for a tool transform that contact nothing, the usual posture first."""
        starts = self.inverse.starts(target, current, seed, restarts)
        for q in self.inverse.solutions(target, starts):
            if self.scene.is_free(q, state, MARGIN):
                yield q
            else:
                self.near.update(*(contact.names for contact in self.scene.contacts(q, state)))

    def _scene(self, cell: Cell) -> CollisionScene:
        shapes = {name: body.shape for name, body in cell.bodies.items()}
        fixed = frozenset(name for name, body in cell.bodies.items() if body.is_fixed)
        key = (*shapes.items(), fixed)
        if key not in self._scenes:
            if len(self._scenes) >= 8:
                self._scenes.clear()
            self._scenes[key] = CollisionScene(self.robot, shapes, fixed)
        return self._scenes[key]


def _to_tool(pose: Pose, tool: Array) -> Array:
    """Return a body's transform to the tool (4, 4)."""
    rotation, position = tool[:3, :3], tool[:3, 3]
    body = transform_of(pose)
    body[:3, 3] = rotation.T @ (body[:3, 3] - position)
    body[:3, :3] = rotation.T @ body[:3, :3]
    return body


def largest_joint_change(a: Array, b: Array) -> float:
    """Return the largest difference of any joint [rad]."""
    return float(np.abs(a - b).max())
