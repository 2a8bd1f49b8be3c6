"""The simulated cell in PyBullet. A reset takes 12 ms."""

import shutil
import tempfile
import time
import weakref
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from kinematics.errors import NoDisplay
from kinematics.geometry.transforms import Array, Pose, Vector
from kinematics.planning.trajectory import TIME_STEP
from kinematics.robot import models
from kinematics.robot.robot import Robot, panda
from kinematics.shapes.bodies import TABLE
from kinematics.simulation import pybullet_loading, window
from kinematics.simulation.bullet_bodies import CollisionBodies
from kinematics.simulation.bullet_robot import BulletRobot
from kinematics.simulation.simulated_cell import SimulatedCell

SOLVER_ITERATIONS = 100
RESIDUAL = 1e-6  # at which the solver stops early
MANY = 14  # movable bodies; if there are more, those at rest sleep, or a step would take ten times as long
CONTACT = 1e-3  # distance at which bodies count as touching [m]


class BulletCell(SimulatedCell):
    """A robot on a table, with bodies, in PyBullet."""

    def __init__(self, robot: Robot | None = None, gui: bool = False) -> None:
        robot = robot or panda()
        self._bullet: Any = pybullet_loading.load()
        self._client: int = window.connect(self._bullet) if gui else self._bullet.connect(self._bullet.DIRECT)
        self._has_window = gui
        folder = Path(tempfile.mkdtemp(prefix="kinematics_"))
        self._disconnect = weakref.finalize(self, _disconnect, self._bullet, self._client, folder)
        self._urdf = folder / "robot.urdf"
        self._urdf.write_text(models.for_bullet(robot, visuals=gui), encoding="utf-8")
        self._collision_bodies = CollisionBodies(self._bullet, self._client, folder)
        super().__init__(robot)

    def _close(self) -> None:
        """Disconnect from PyBullet, and remove the robot's temporary description."""
        self._disconnect()  # once; garbage collection does the same
        self._client = -1

    # -- measurements ----------------------------------------------------------------------

    def joint_positions(self) -> Array:
        return self._robot.joint_positions()

    def link_poses(self) -> dict[str, Pose]:
        return self._robot.link_poses()

    def joint_torques(self) -> Array:
        return self._robot.joint_torques()

    def all_joints(self) -> dict[str, float]:
        return self._robot.all_joints()

    def tool_pose(self) -> Pose:
        return self._robot.tool_pose()

    def pressed(self) -> frozenset[str]:
        return frozenset(self._names[each] for each in self._robot.pressed() if each in self._names)

    # -- commands --------------------------------------------------------------------------

    def step(self) -> None:
        """Simulate one time step under the present motor commands; with a window, in real time."""
        super().step()
        if self._has_window:
            time.sleep(TIME_STEP)

    def _drive_arm(self, position: Sequence[float], velocity: Sequence[float]) -> None:
        self._robot.drive_arm(position, velocity)

    # -- inside ----------------------------------------------------------------------------

    def _build(self) -> None:
        world, client = self._bullet, self._client
        world.resetSimulation(physicsClientId=client)
        world.setPhysicsEngineParameter(
            fixedTimeStep=TIME_STEP,
            numSolverIterations=SOLVER_ITERATIONS,
            solverResidualThreshold=RESIDUAL,
            deterministicOverlappingPairs=1,
            physicsClientId=client,
        )
        world.setGravity(0, 0, -9.81, physicsClientId=client)
        plane = world.createCollisionShape(world.GEOM_PLANE, physicsClientId=client)
        self._table = world.createMultiBody(0, plane, physicsClientId=client)
        world.changeDynamics(self._table, -1, lateralFriction=1.0, physicsClientId=client)
        self._robot = BulletRobot(self.robot, world, client, self._urdf)
        self._collision_bodies.clear()
        many = sum(not body.is_fixed for body in self.bodies.values()) > MANY
        self._ids = {body.name: self._collision_bodies.add(body, many) for body in self.bodies.values()}
        self._names = {identity: name for name, identity in self._ids.items()}
        if self._has_window:
            for name, identity in self._ids.items():
                window.paint(world, client, identity, self.bodies[name])

    def _advance(self) -> None:
        if self._has_window and not self._bullet.isConnected(self._client):
            raise NoDisplay("the window was closed")
        self._bullet.stepSimulation(physicsClientId=self._client)

    def _pose(self, name: str) -> Pose:
        return Pose(
            *self._bullet.getBasePositionAndOrientation(self._ids[name], physicsClientId=self._client)
        )

    def _velocity(self, name: str) -> tuple[Sequence[float], Sequence[float]]:
        linear, angular = self._bullet.getBaseVelocity(self._ids[name], physicsClientId=self._client)
        return linear, angular

    def _touch(self, a: str, b: str) -> bool:
        ids = [self._table if name == TABLE else self._ids[name] for name in (a, b)]
        points = self._bullet.getContactPoints(ids[0], ids[1], physicsClientId=self._client)
        return any(point[8] < CONTACT for point in points)

    def _pressing(self) -> tuple[dict[str, float], dict[str, float]]:
        left, right = (
            {self._names[each]: force for each, force in side.items() if each in self._names}
            for side in self._robot.pressing()
        )
        return left, right

    def _drive_fingers(self, opening: float, force: float, speed: float) -> None:
        self._robot.drive_fingers(opening, force, speed)

    def _press_fingers(self, force: float, speed: float) -> None:
        self._robot.close_fingers(force, speed)

    def _apply_force(self, name: str, force: Vector, at: Vector) -> None:
        self._bullet.applyExternalForce(
            self._ids[name], -1, force, at, self._bullet.WORLD_FRAME, physicsClientId=self._client
        )


def _disconnect(world: Any, client: int, folder: Path) -> None:
    with pybullet_loading.output_silenced():
        world.disconnect(physicsClientId=client)
    shutil.rmtree(folder, ignore_errors=True)
