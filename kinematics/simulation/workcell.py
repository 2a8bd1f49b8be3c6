"""The simulated cell: motor commands in, measurements out. Friction and gravity only, in PyBullet.

The arm's base is at the world's origin, the table's top is the plane z = 0. Every reset rebuilds the world
(12 ms), so that nothing of an earlier episode has an effect, not even the order of its contacts.
"""

import math
import shutil
import tempfile
import time
import weakref
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from kinematics.collision.self_contact import always_touching
from kinematics.errors import NoDisplay, UnknownBody
from kinematics.geometry.transforms import Array, Pose, Vector, check_pose
from kinematics.planning.trajectory import TIME_STEP
from kinematics.robot import models
from kinematics.robot.gripper import gripper_of
from kinematics.robot.robot import Robot, panda
from kinematics.shapes.bodies import TABLE, Body, check_body
from kinematics.shapes.pose_noise import NO_NOISE, Noise
from kinematics.shapes.shapes import half_extents_of
from kinematics.simulation import pybullet_loading, window
from kinematics.simulation.bullet_bodies import CollisionBodies
from kinematics.simulation.bullet_robot import CLOSING_SPEED, GRIP_FORCE, BulletRobot
from kinematics.simulation.camera import Camera

FRAME_STEPS = 24  # between two calls of `on_frame`: 0.1 s
SOLVER_ITERATIONS = 100
RESIDUAL = 1e-6  # at which the solver stops early
MANY = 14  # movable bodies; if there are more, those at rest sleep, or a step would take ten times as long
STILL = 0.01  # speed below which a body is at rest [m/s]
CONTACT = 1e-3  # distance at which bodies count as touching [m]
_PUSH_STEPS = 12
_PUSH_ABOVE_CENTRE = 0.015  # [m]


class Workcell:
    """A robot on a table, with bodies."""

    def __init__(self, robot: Robot | None = None, gui: bool = False) -> None:
        self.robot = robot or panda()
        always_touching(self.robot)  # an arm that no motion could use is refused here, not at the first one
        models.pinocchio_model(self.robot)
        self.gripper = gripper_of(self.robot)
        self._bullet: Any = pybullet_loading.load()
        self._client: int = window.connect(self._bullet) if gui else self._bullet.connect(self._bullet.DIRECT)
        self._has_window = gui
        folder = Path(tempfile.mkdtemp(prefix="kinematics_"))
        self._disconnect = weakref.finalize(self, _disconnect, self._bullet, self._client, folder)
        self._urdf = folder / "robot.urdf"
        self._urdf.write_text(models.for_bullet(self.robot, visuals=gui), encoding="utf-8")
        self._collision_bodies = CollisionBodies(self._bullet, self._client, folder)
        self._camera: Camera | None = None
        self.on_frame: Callable[[], None] | None = None
        self.reset([], seed=0)

    # -- the world -------------------------------------------------------------------------

    def reset(self, bodies: Sequence[Body], seed: int, noise: Noise = NO_NOISE) -> None:
        """Put the arm at home with an open hand and the bodies at their poses, settle, and zero the clock.

        Args:
            noise: on the poses that skills observe; `pose` and `poses` stay exact.
        """
        _check_bodies(bodies)
        self.noise = noise
        self._noise_generator = np.random.default_rng((seed % 2**32, 2))
        self.stop_requested = False
        self.bodies: Mapping[str, Body] = {body.name: body for body in bodies}
        self.seed = seed
        self._build()
        self._steps = 0
        self.stepping_seconds = 0.0  # wall time spent in the simulator since the reset
        self.frame_seconds = 0.0  # wall time spent in `on_frame` since the reset
        frame, self.on_frame = self.on_frame, None
        self.settle(0.2)
        self.on_frame = frame
        self._steps = 0

    def close(self) -> None:
        """Disconnect from PyBullet, and remove the robot's temporary description."""
        if self._camera is not None:
            self._camera.close()
            self._camera = None
        self._disconnect()  # once; garbage collection does the same
        self._client = -1

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    # -- measurements ----------------------------------------------------------------------

    @property
    def time(self) -> float:
        """Simulated time since the reset [s]."""
        return self._steps * TIME_STEP

    def pose(self, name: str) -> Pose:
        """Return the pose of a body's centre, world frame."""
        position, quaternion = self._bullet.getBasePositionAndOrientation(
            self._id(name), physicsClientId=self._client
        )
        return check_pose(name, Pose(position, quaternion))

    def poses(self) -> dict[str, Pose]:
        """Return the poses of all bodies' centres, world frame."""
        return {name: self.pose(name) for name in self.bodies}

    def observed_poses(self) -> dict[str, Pose]:
        """Return the poses of all bodies as one observation gives them, world frame."""
        poses = self.poses()
        return poses if self.noise == NO_NOISE else self.noise.applied(poses, self._noise_generator)

    def observed_pose(self, name: str) -> Pose:
        """Return the pose of a body as one observation gives it, world frame."""
        pose = self.pose(name)
        if self.noise == NO_NOISE:
            return pose
        return self.noise.applied({name: pose}, self._noise_generator)[name]

    def speed(self, name: str) -> float:
        """Return an upper bound on the speed of any point of the body [m/s]."""
        linear, angular = self._bullet.getBaseVelocity(self._id(name), physicsClientId=self._client)
        radius = math.hypot(*half_extents_of(self.bodies[name].shape))
        return math.hypot(*linear) + radius * math.hypot(*angular)

    def contacts(self, a: str, b: str) -> bool:
        """Return whether two bodies touch; the table is called `TABLE`."""
        ids = [self._table if name == TABLE else self._id(name) for name in (a, b)]
        points = self._bullet.getContactPoints(ids[0], ids[1], physicsClientId=self._client)
        return any(point[8] < CONTACT for point in points)

    def joint_positions(self) -> Array:
        """Return the arm's joint positions (dof,) [rad]."""
        return self._robot.joint_positions()

    def link_poses(self) -> dict[str, Pose]:
        """Return the poses of all links of the robot, world frame."""
        return self._robot.link_poses()

    def joint_torques(self) -> Array:
        """Return the last torques of the arm's motors (dof,) [N m]."""
        return self._robot.joint_torques()

    def all_joints(self) -> dict[str, float]:
        """Return the positions of arm and finger joints, by the URDF's names [rad] or [m]."""
        return self._robot.all_joints()

    def tool_pose(self) -> Pose:
        """Return the pose of the tool frame, between the fingertips, z along the approach; world frame."""
        return self._robot.tool_pose()

    def tool_position(self) -> Vector:
        """Return the position of the tool frame, world frame [m]."""
        return self.tool_pose().position

    def finger_width(self) -> float:
        """Return the distance between the fingers [m]."""
        return self._robot.finger_width()

    def held(self) -> str | None:
        """Return the body that a closed hand touches with both fingers while they are apart."""
        if not self.hand_closed or self.finger_width() < 2e-3:
            return None
        left, right = self._robot.pressing()
        squeezed = left.keys() & right.keys() & self._names.keys()
        both = {self._names[each]: min(left[each], right[each]) for each in squeezed}
        return min(both, key=lambda name: (-both[name], name), default=None)

    def touched(self) -> frozenset[str]:
        """Return the bodies that either finger presses on."""
        left, right = self._robot.pressing()
        return frozenset(self._names[each] for each in left.keys() | right.keys() if each in self._names)

    def pressed(self) -> frozenset[str]:
        """Return the bodies that any part of the robot presses on."""
        return frozenset(self._names[each] for each in self._robot.pressed() if each in self._names)

    # -- commands --------------------------------------------------------------------------

    def step(self) -> None:
        """Simulate one time step under the present motor commands."""
        started = time.perf_counter()
        self._bullet.stepSimulation(physicsClientId=self._client)
        self.stepping_seconds += time.perf_counter() - started
        self._steps += 1
        if self._has_window:
            self._show()
        if self._steps % FRAME_STEPS == 0 and self.on_frame is not None:
            started = time.perf_counter()
            self.on_frame()
            self.frame_seconds += time.perf_counter() - started

    def settle(self, seconds: float) -> None:
        """Let simulated time pass [s]."""
        for _ in range(round(seconds / TIME_STEP)):
            self.step()

    def settle_until_still(self, names: Sequence[str], at_most: float) -> None:
        """Let time pass until the bodies are at rest, `at_most` so long [s]."""
        deadline = self._steps + round(at_most / TIME_STEP)
        while self._steps < deadline:
            self.settle(0.05)
            if all(self.speed(name) < STILL for name in names):
                return

    def drive_arm(self, position: Sequence[float], velocity: Sequence[float]) -> None:
        """Set the set points of the arm's controllers, with velocity feed-forward [rad], [rad/s]."""
        self._robot.drive_arm(position, velocity)

    def hold(self) -> None:
        """Hold the arm where it is; the fingers keep their command."""
        here = self.joint_positions().tolist()
        self.drive_arm(here, [0.0] * len(here))

    def stop(self) -> None:
        """Stop the current motion (from `on_frame`, or another thread): brake, then hold.

        The skill ends with the reason `stopped`; the next one may continue from there.
        """
        self.stop_requested = True

    def open_fingers(self, opening: float, speed: float = CLOSING_SPEED) -> None:
        """Command the fingers to an opening [m], each with at most a speed [m/s]."""
        self.hand_closed = False
        self._robot.drive_fingers(opening, GRIP_FORCE, speed)

    def close_fingers(self) -> None:
        """Command the fingers to close and to keep pressing."""
        self.hand_closed = True
        self._robot.close_fingers()

    def weaken_fingers(self) -> None:
        """Disturb the grasp: the fingers lose their force and give way, in spite of their command."""
        self._robot.drive_fingers(0.5 * self.finger_width() + 3e-3, force=2.0)

    def push(self, name: str, impulse_Ns: float, direction_xy: tuple[float, float]) -> None:
        """Push a body horizontally, above its centre, for 50 ms; then wait until all bodies are at rest."""
        length = math.hypot(*direction_xy)
        if not (math.isfinite(impulse_Ns) and math.isfinite(length) and length > 0):
            raise ValueError(f"no push: {impulse_Ns} N s towards {direction_xy}")
        strength = impulse_Ns / (_PUSH_STEPS * TIME_STEP) / length
        force = (direction_xy[0] * strength, direction_xy[1] * strength, 0.0)
        for _ in range(_PUSH_STEPS):
            x, y, z = self.pose(name).position
            self._bullet.applyExternalForce(
                self._id(name),
                -1,
                force,
                (x, y, z + _PUSH_ABOVE_CENTRE),
                self._bullet.WORLD_FRAME,
                physicsClientId=self._client,
            )
            self.step()
        self.settle_until_still(list(self.bodies), at_most=2.0)

    def render(self, width: int, height: int, smooth: bool = True) -> NDArray[np.uint8]:
        """Return a picture of the cell from the front and above (height, width, 3)."""
        if self._camera is None:
            self._camera = Camera(self.robot)
        return self._camera.picture(self.bodies, self.poses(), self.all_joints(), width, height, smooth)

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
        self.open_fingers(self.gripper.maximum_opening)
        self._collision_bodies.clear()
        many = sum(not body.is_fixed for body in self.bodies.values()) > MANY
        self._ids = {body.name: self._collision_bodies.add(body, many) for body in self.bodies.values()}
        self._names = {identity: name for name, identity in self._ids.items()}
        if self._has_window:
            for name, identity in self._ids.items():
                window.paint(world, client, identity, self.bodies[name])

    def _show(self) -> None:
        """Keep to real time; raise `NoDisplay` once the window was closed."""
        if not self._bullet.isConnected(self._client):
            raise NoDisplay("the window was closed")
        time.sleep(TIME_STEP)

    def _id(self, name: str) -> int:
        if name not in self._ids:
            raise UnknownBody(name, self._ids)
        return self._ids[name]


def _disconnect(world: Any, client: int, folder: Path) -> None:
    with pybullet_loading.output_silenced():
        world.disconnect(physicsClientId=client)
    shutil.rmtree(folder, ignore_errors=True)


def _check_bodies(bodies: Sequence[Body]) -> None:
    for body in bodies:
        check_body(body)
    names = [body.name for body in bodies]
    if len(set(names)) < len(names) or TABLE in names:
        raise ValueError(f"names of bodies must be unique, and none may be '{TABLE}': {names}")
