"""A simulated cell: clock, frames, noise and disturbances over any engine that steps the physics.

The arm's base is where its description has it, the table's top is the plane z = 0. Every reset rebuilds the
world, so that nothing of an earlier episode has an effect, not even the order of its contacts.
"""

import math
import time
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from typing import Self

import numpy as np
from numpy.typing import NDArray

from kinematics.collision.self_contact import always_touching
from kinematics.errors import UnknownBody
from kinematics.geometry.transforms import Array, Pose, Vector, check_pose
from kinematics.planning.trajectory import TIME_STEP
from kinematics.robot import models
from kinematics.robot.gripper import gripper_of
from kinematics.robot.robot import Robot, panda
from kinematics.shapes.bodies import TABLE, Body, check_body
from kinematics.shapes.pose_noise import NO_NOISE, Noise
from kinematics.shapes.shapes import half_extents_of
from kinematics.simulation.camera import Camera

FRAME_STEPS = 24  # between two calls of `on_frame`: 0.1 s
STILL = 0.01  # speed below which a body is at rest [m/s]
CLOSING_SPEED = 0.15  # of each finger [m/s]
GRIP_FORCE = 40.0  # of each finger [N]
WEAK_FORCE = 2.0  # of each finger that gives way [N]
_PUSH_STEPS = 12
_PUSH_ABOVE_CENTRE = 0.015  # [m]


class SimulatedCell(ABC):
    """A robot on a table, with bodies. Friction and gravity only. It is a `Cell`."""

    def __init__(self, robot: Robot | None = None) -> None:
        self.robot = robot or panda()
        always_touching(self.robot)  # an arm that no motion could use is refused here, not at the first one
        models.pinocchio_model(self.robot)
        self.gripper = gripper_of(self.robot)
        self._camera: Camera | None = None
        self.on_frame: Callable[[], None] | None = None
        self.reset([], seed=0)

    # -- the world -------------------------------------------------------------------------

    def reset(
        self,
        bodies: Sequence[Body],
        seed: int,
        noise: Noise = NO_NOISE,
        camera_offset: Vector = (0.0, 0.0, 0.0),
        grip: float = GRIP_FORCE,
    ) -> None:
        """Put the arm at home with an open hand and the bodies at their poses, settle, and zero the clock.

        Args:
            noise: on the poses that skills observe; `pose` and `poses` stay exact.
            camera_offset: by which all observed poses are off, unknown to the skills, world frame [m].
            grip: force of each finger [N].
        """
        _check_bodies(bodies)
        self.noise, self._camera_offset, self._grip = noise, camera_offset, grip
        self._noise_generator = np.random.default_rng((seed % 2**32, 2))
        self.stop_requested = False
        self.bodies: Mapping[str, Body] = {body.name: body for body in bodies}
        self.seed = seed
        self._build()
        self.open_fingers(self.gripper.maximum_opening)
        self._steps = 0
        self.stepping_seconds = 0.0  # wall time spent in the simulator since the reset
        self.frame_seconds = 0.0  # wall time spent in `on_frame` since the reset
        frame, self.on_frame = self.on_frame, None
        self.settle(0.2)
        self.on_frame = frame
        self._steps = 0

    def close(self) -> None:
        """Give back what the camera and the engine hold."""
        if self._camera is not None:
            self._camera.close()
            self._camera = None
        self._close()

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
        if name not in self.bodies:
            raise UnknownBody(name, self.bodies)
        return check_pose(name, self._pose(name))

    def poses(self) -> dict[str, Pose]:
        """Return the poses of all bodies' centres, world frame."""
        return {name: self.pose(name) for name in self.bodies}

    def observed_poses(self) -> dict[str, Pose]:
        """Return the poses of all bodies as one observation gives them, world frame."""
        return self._observed(self.poses())

    def observed_pose(self, name: str) -> Pose:
        """Return the pose of a body as one observation gives it, world frame."""
        return self._observed({name: self.pose(name)})[name]

    def _observed(self, poses: dict[str, Pose]) -> dict[str, Pose]:
        if any(self._camera_offset):
            poses = {name: _shifted(pose, self._camera_offset) for name, pose in poses.items()}
        return poses if self.noise == NO_NOISE else self.noise.applied(poses, self._noise_generator)

    def speed(self, name: str) -> float:
        """Return an upper bound on the speed of any point of the body [m/s]."""
        if name not in self.bodies:
            raise UnknownBody(name, self.bodies)
        linear, angular = self._velocity(name)
        radius = math.hypot(*half_extents_of(self.bodies[name].shape))
        return math.hypot(*linear) + radius * math.hypot(*angular)

    def contacts(self, a: str, b: str) -> bool:
        """Return whether two bodies touch; the table is called `TABLE`."""
        for name in (a, b):
            if name != TABLE and name not in self.bodies:
                raise UnknownBody(name, self.bodies)
        return self._touch(a, b)

    @abstractmethod
    def joint_positions(self) -> Array:
        """Return the arm's joint positions (dof,) [rad]."""

    @abstractmethod
    def link_poses(self) -> dict[str, Pose]:
        """Return the poses of all links of the robot, world frame."""

    @abstractmethod
    def joint_torques(self) -> Array:
        """Return the last torques of the arm's motors (dof,): skills look at their changes only [N m]."""

    @abstractmethod
    def all_joints(self) -> dict[str, float]:
        """Return the positions of arm and finger joints, by the URDF's names [rad] or [m]."""

    @abstractmethod
    def tool_pose(self) -> Pose:
        """Return the pose of the tool frame, between the fingertips, z along the approach; world frame."""

    def tool_position(self) -> Vector:
        """Return the position of the tool frame, world frame [m]."""
        return self.tool_pose().position

    def finger_width(self) -> float:
        """Return the distance between the fingers, from the first and the last finger joint [m]."""
        joints = self.all_joints()
        ends = self.robot.finger_joints[0], self.robot.finger_joints[-1]
        return self.gripper.width_at(*(joints[joint.name] for joint in ends))

    def held(self) -> str | None:
        """Return the body that a closed hand touches with both fingers while they are apart."""
        if not self.hand_closed or self.finger_width() < 2e-3:
            return None
        left, right = self._pressing()
        both = {name: min(left[name], right[name]) for name in left.keys() & right.keys()}
        return min(both, key=lambda name: (-both[name], name), default=None)

    def touched(self) -> frozenset[str]:
        """Return the bodies that either finger presses on."""
        left, right = self._pressing()
        return frozenset(left.keys() | right.keys())

    @abstractmethod
    def pressed(self) -> frozenset[str]:
        """Return the bodies that any part of the robot presses on."""

    # -- commands --------------------------------------------------------------------------

    def step(self) -> None:
        """Simulate one time step under the present motor commands."""
        started = time.perf_counter()
        self._advance()
        self.stepping_seconds += time.perf_counter() - started
        self._steps += 1
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
        self._drive_arm(position, velocity)

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
        self._drive_fingers(opening, self._grip, speed)

    def close_fingers(self) -> None:
        """Command the fingers to close and to keep pressing."""
        self.hand_closed = True
        self._press_fingers(self._grip, CLOSING_SPEED)

    def weaken_fingers(self) -> None:
        """Disturb the grasp: the fingers lose their force and give way, in spite of their command."""
        self._drive_fingers(0.5 * self.finger_width() + 3e-3, min(WEAK_FORCE, self._grip), CLOSING_SPEED)

    def push(self, name: str, impulse_Ns: float, direction_xy: tuple[float, float]) -> None:
        """Push a body horizontally, above its centre, for 50 ms; then wait until all bodies are at rest."""
        length = math.hypot(*direction_xy)
        if not (math.isfinite(impulse_Ns) and math.isfinite(length) and length > 0):
            raise ValueError(f"no push: {impulse_Ns} N s towards {direction_xy}")
        strength = impulse_Ns / (_PUSH_STEPS * TIME_STEP) / length
        force = (direction_xy[0] * strength, direction_xy[1] * strength, 0.0)
        for _ in range(_PUSH_STEPS):
            x, y, z = self.pose(name).position
            self._apply_force(name, force, (x, y, z + _PUSH_ABOVE_CENTRE))
            self.step()
        self.settle_until_still(list(self.bodies), at_most=2.0)

    def render(self, width: int, height: int, smooth: bool = True) -> NDArray[np.uint8]:
        """Return a picture of the cell from the front and above (height, width, 3), drawn by PyBullet."""
        if self._camera is None:
            self._camera = Camera(self.robot)
        return self._camera.picture(self.bodies, self.poses(), self.all_joints(), width, height, smooth)

    # -- what an engine brings -------------------------------------------------------------

    @abstractmethod
    def _build(self) -> None:
        """Build the world of `self.bodies`, with the arm at home and the fingers wide open."""

    @abstractmethod
    def _close(self) -> None: ...

    @abstractmethod
    def _advance(self) -> None:
        """Simulate one time step; forces that were applied act during it."""

    @abstractmethod
    def _pose(self, name: str) -> Pose: ...

    @abstractmethod
    def _velocity(self, name: str) -> tuple[Sequence[float], Sequence[float]]:
        """Return a body's linear and angular velocity, of which only the lengths count [m/s], [rad/s]."""

    @abstractmethod
    def _touch(self, a: str, b: str) -> bool: ...

    @abstractmethod
    def _pressing(self) -> tuple[dict[str, float], dict[str, float]]:
        """Return for each side of the hand the bodies that it presses on, with the forces [N]."""

    @abstractmethod
    def _drive_arm(self, position: Sequence[float], velocity: Sequence[float]) -> None: ...

    @abstractmethod
    def _drive_fingers(self, opening: float, force: float, speed: float) -> None:
        """Drive each finger to an opening [m] with at most a force [N] and a speed [m/s]."""

    @abstractmethod
    def _press_fingers(self, force: float, speed: float) -> None:
        """Close the fingers with at most a speed [m/s], and keep pressing with a force each [N]."""

    @abstractmethod
    def _apply_force(self, name: str, force: Vector, at: Vector) -> None:
        """Apply a force [N] at a point [m] of a body during the next step, world frame."""


def _shifted(pose: Pose, by: Vector) -> Pose:
    x, y, z = (a + b for a, b in zip(pose.position, by, strict=True))
    return Pose((x, y, z), pose.quaternion_xyzw)


def _check_bodies(bodies: Sequence[Body]) -> None:
    for body in bodies:
        check_body(body)
    names = [body.name for body in bodies]
    if len(set(names)) < len(names) or TABLE in names:
        raise ValueError(f"names of bodies must be unique, and none may be '{TABLE}': {names}")
