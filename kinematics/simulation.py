"""The simulated cell: motor commands in, what is measured out. Friction and gravity only, in
PyBullet.

The Panda stands at the world's origin, the table's top is the plane z = 0. Every reset builds the
world anew (12 ms): then nothing of an earlier episode, not even the order of its contacts, is left
to be felt.
"""

import math
import shutil
import tempfile
import time
import weakref
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kinematics import bullet, robot
from kinematics.camera import Camera
from kinematics.geometry import Array, Body, Pose, Vector, check_pose
from kinematics.reasons import UnknownBody
from kinematics.trajectory import TIME_STEP

TABLE = "table"
FRAME_STEPS = 24  # between two calls of `on_frame`: 0.1 s
GRIP_FORCE = 40.0  # of each finger [N]
CLOSING_SPEED = 0.15  # of each finger [m/s]
SOLVER_ITERATIONS = 100
RESIDUAL = 1e-6  # at which the solver stops early
STILL = 0.01  # a body this slow has come to rest [m/s]
_ARM = tuple(range(7))
_FINGERS = (9, 10)
_TOOL = 11
_POSITION_GAIN = 0.2
_PUSH_STEPS = 12
_PUSH_ABOVE_CENTRE = 0.015  # [m]


class Workcell:
    """The robot on a table, with boxes."""

    def __init__(self) -> None:
        self._bullet: Any = bullet.load()
        self._client: int = self._bullet.connect(self._bullet.DIRECT)
        folder = Path(tempfile.mkdtemp(prefix="kinematics_"))
        self._let_go = weakref.finalize(self, _let_go, self._bullet, self._client, folder)
        self._urdf = folder / "panda.urdf"
        self._urdf.write_text(robot.description_for_bullet())
        self._effort = robot.limits().effort.tolist()
        self._camera: Camera | None = None
        self.on_frame: Callable[[], None] | None = None
        self.reset([], seed=0)

    # -- the world -------------------------------------------------------------------------

    def reset(self, bodies: Sequence[Body], seed: int) -> None:
        """Arm at home with an open hand, bodies where they are said to be, settled; the clock at
        zero.
        """
        _check_bodies(bodies)
        self.bodies: Mapping[str, Body] = {body.name: body for body in bodies}
        self.seed = seed
        self._build()
        self._steps = 0
        self.stepping_seconds = 0.0  # wall time spent in the simulator since the reset
        self.watching_seconds = 0.0  # wall time spent in `on_frame` since the reset
        frame, self.on_frame = self.on_frame, None
        self.settle(0.2)
        self.on_frame = frame
        self._steps = 0

    def close(self) -> None:
        """Disconnect, and remove the robot's temporary description."""
        if self._camera is not None:
            self._camera.close()
            self._camera = None
        self._let_go()  # once; a cell that is forgotten does the same
        self._client = -1

    def __enter__(self) -> "Workcell":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    # -- what is measured ------------------------------------------------------------------

    @property
    def time(self) -> float:
        """Simulated time since the reset [s]."""
        return self._steps * TIME_STEP

    def pose(self, name: str) -> Pose:
        """Of a body's centre, world frame."""
        position, quaternion = self._bullet.getBasePositionAndOrientation(
            self._id(name), physicsClientId=self._client
        )
        return check_pose(name, Pose(position, quaternion))

    def poses(self) -> dict[str, Pose]:
        """Of all bodies' centres, world frame."""
        return {name: self.pose(name) for name in self.bodies}

    def speed(self, name: str) -> float:
        """At most this fast is any point of the body [m/s]."""
        linear, angular = self._bullet.getBaseVelocity(self._id(name), physicsClientId=self._client)
        radius = math.hypot(*self.bodies[name].half_extents)
        return math.hypot(*linear) + radius * math.hypot(*angular)

    def contacts(self, a: str, b: str) -> bool:
        """Whether two bodies touch; the table is called 'table'."""
        ids = [self._table if name == TABLE else self._id(name) for name in (a, b)]
        points = self._bullet.getContactPoints(ids[0], ids[1], physicsClientId=self._client)
        return any(point[8] < 1e-3 for point in points)

    def joint_positions(self) -> Array:
        """Of the arm [rad]."""
        states = self._bullet.getJointStates(self._robot, _ARM, physicsClientId=self._client)
        return np.array([state[0] for state in states])

    def tool_pose(self) -> Pose:
        """Of the point between the fingertips, where a grasped body's centre is; z along the
        approach.
        """
        state = self._bullet.getLinkState(
            self._robot, _TOOL, computeForwardKinematics=1, physicsClientId=self._client
        )
        return Pose(state[4], state[5])

    def tool_position(self) -> Vector:
        """World frame [m]."""
        return self.tool_pose().position

    def finger_width(self) -> float:
        """Between the fingers [m]."""
        states = self._bullet.getJointStates(self._robot, _FINGERS, physicsClientId=self._client)
        return float(states[0][0] + states[1][0])

    def held(self) -> str | None:
        """The body that a closed hand touches with both fingers, these being apart."""
        if not self.hand_closed or self.finger_width() < 2e-3:
            return None
        left, right = (self._pressing(finger) for finger in _FINGERS)
        both = left.keys() & right.keys()
        return min(both, key=lambda name: (-min(left[name], right[name]), name), default=None)

    # -- what is done ----------------------------------------------------------------------

    def step(self) -> None:
        """One time step under the present motor commands."""
        started = time.perf_counter()
        self._bullet.stepSimulation(physicsClientId=self._client)
        self.stepping_seconds += time.perf_counter() - started
        self._steps += 1
        if self._steps % FRAME_STEPS == 0 and self.on_frame is not None:
            started = time.perf_counter()
            self.on_frame()
            self.watching_seconds += time.perf_counter() - started

    def settle(self, seconds: float) -> None:
        """Let simulated time pass."""
        for _ in range(round(seconds / TIME_STEP)):
            self.step()

    def settle_until_still(self, names: Sequence[str], at_most: float) -> None:
        """Let time pass until the bodies have come to rest, `at_most` so long [s]."""
        deadline = self._steps + round(at_most / TIME_STEP)
        while self._steps < deadline:
            self.settle(0.05)
            if all(self.speed(name) < STILL for name in names):
                return

    def drive_arm(self, position: Sequence[float], velocity: Sequence[float]) -> None:
        """Set points of the arm's controllers, with velocity feed-forward [rad], [rad/s]."""
        self._bullet.setJointMotorControlArray(
            self._robot,
            _ARM,
            self._bullet.POSITION_CONTROL,
            targetPositions=position,
            targetVelocities=velocity,
            forces=self._effort,
            positionGains=[_POSITION_GAIN] * 7,
            physicsClientId=self._client,
        )

    def open_fingers(self, opening: float, force: float = GRIP_FORCE) -> None:
        """Tell the fingers to go this far from the middle [m]."""
        self.hand_closed = False
        self._drive_fingers(opening, force)

    def close_fingers(self) -> None:
        """Tell the fingers to close, and to keep pressing."""
        self.hand_closed = True
        for finger in _FINGERS:
            self._bullet.setJointMotorControl2(
                self._robot,
                finger,
                self._bullet.VELOCITY_CONTROL,
                targetVelocity=-CLOSING_SPEED,
                force=GRIP_FORCE,
                physicsClientId=self._client,
            )

    def weaken_fingers(self) -> None:
        """The disturbance: the fingers lose their force and give way, though told to hold."""
        self._drive_fingers(0.5 * self.finger_width() + 3e-3, force=2.0)

    def push(self, name: str, impulse_Ns: float, direction_xy: tuple[float, float]) -> None:
        """Push a body above its centre for 50 ms, horizontally; then wait until all has come to
        rest.
        """
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
        """A picture of the cell from the front and above: (height, width, 3)."""
        if self._camera is None:
            self._camera = Camera()
        fingers = self._bullet.getJointStates(self._robot, _FINGERS, physicsClientId=self._client)
        joints = [*self.joint_positions().tolist(), *(state[0] for state in fingers)]
        return self._camera.picture(self.bodies, self.poses(), joints, width, height, smooth)

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
        with bullet.output_silenced():
            self._robot = world.loadURDF(str(self._urdf), useFixedBase=True, physicsClientId=client)
        self._place_arm()
        shapes: dict[Vector, int] = {}
        self._ids = {body.name: self._add(body, shapes) for body in self.bodies.values()}
        self._names = {identity: name for name, identity in self._ids.items()}

    def _place_arm(self) -> None:
        world, client = self._bullet, self._client
        home = robot.HOME.tolist()
        for joint in _ARM:
            world.resetJointState(self._robot, joint, home[joint], physicsClientId=client)
        for finger in _FINGERS:
            world.resetJointState(self._robot, finger, robot.MAXIMUM_OPENING, physicsClientId=client)
        gear = world.createConstraint(
            self._robot,
            _FINGERS[0],
            self._robot,
            _FINGERS[1],
            world.JOINT_GEAR,
            [1, 0, 0],
            [0, 0, 0],
            [0, 0, 0],
            physicsClientId=client,
        )
        world.changeConstraint(gear, gearRatio=-1, erp=0.1, maxForce=50, physicsClientId=client)
        self.drive_arm(home, [0.0] * 7)
        self.open_fingers(robot.MAXIMUM_OPENING)

    def _add(self, body: Body, shapes: dict[Vector, int]) -> int:
        world, client = self._bullet, self._client
        if body.half_extents not in shapes:
            shapes[body.half_extents] = world.createCollisionShape(
                world.GEOM_BOX, halfExtents=body.half_extents, physicsClientId=client
            )
        identity: int = world.createMultiBody(
            body.mass,
            shapes[body.half_extents],
            -1,
            body.position,
            body.quaternion_xyzw,
            physicsClientId=client,
        )
        world.changeDynamics(identity, -1, lateralFriction=1.0, physicsClientId=client)
        return identity

    def _drive_fingers(self, opening: float, force: float) -> None:
        for finger in _FINGERS:
            self._bullet.setJointMotorControl2(
                self._robot,
                finger,
                self._bullet.POSITION_CONTROL,
                targetPosition=opening,
                force=force,
                maxVelocity=CLOSING_SPEED,
                physicsClientId=self._client,
            )

    def _pressing(self, finger: int) -> dict[str, float]:
        """Names of the bodies that a finger presses on, and how hard [N]."""
        forces: dict[str, float] = {}
        for point in self._bullet.getContactPoints(
            bodyA=self._robot, linkIndexA=finger, physicsClientId=self._client
        ):
            name = self._names.get(point[2])
            if name is not None and point[9] > 0:
                forces[name] = forces.get(name, 0.0) + point[9]
        return forces

    def _id(self, name: str) -> int:
        if name not in self._ids:
            raise UnknownBody(name, self._ids)
        return self._ids[name]


def _let_go(bullet: Any, client: int, folder: Path) -> None:
    bullet.disconnect(physicsClientId=client)
    shutil.rmtree(folder, ignore_errors=True)


def _check_bodies(bodies: Sequence[Body]) -> None:
    for body in bodies:
        check_pose(body.name, body.pose)
    names = [body.name for body in bodies]
    if len(set(names)) < len(names) or TABLE in names:
        raise ValueError(f"names of bodies must differ, and none be '{TABLE}': {names}")
