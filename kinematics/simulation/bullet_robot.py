"""The robot inside a PyBullet simulation: set points in, joint states and contacts out."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from kinematics.geometry.transforms import Array, Pose
from kinematics.robot.gripper import gripper_of
from kinematics.robot.robot import Robot
from kinematics.simulation import pybullet_loading

GRIP_FORCE = 40.0  # of each finger [N]
CLOSING_SPEED = 0.15  # of each finger [m/s]
POSITION_GAIN = 0.2
SLIDING_GEAR = {"erp": 0.1, "maxForce": 50}
SWINGING_GEAR = {"erp": 0.8, "maxForce": 1000}  # hinges in a row give way otherwise
PADS: dict[str, dict[str, float]] = {  # of fingers, in what the URDF does not say of how they touch: rubber
    "lateral_friction": {"lateralFriction": 1.0},
    "spinning_friction": {"spinningFriction": 0.1},
    "stiffness": {"contactStiffness": 30000.0, "contactDamping": 1000.0},
    "friction_anchor": {"frictionAnchor": 1},  # without it what is held creeps when the arm is fast
}


class BulletRobot:
    """One robot, newly loaded, at home, with an open hand."""

    def __init__(self, robot: Robot, world: Any, client: int, urdf: Path) -> None:
        self.robot = robot
        self.gripper = gripper_of(robot)
        self._world, self._client = world, client
        with pybullet_loading.output_silenced():
            self.id: int = world.loadURDF(str(urdf), useFixedBase=True, physicsClientId=client)
        self._find_joints()
        self._effort = robot.limits.effort.tolist()
        self._rates = self._finger_rates()
        self._go_home()

    # -- what is measured ------------------------------------------------------------------

    def joint_positions(self) -> Array:
        """Of the arm [rad]."""
        states = self._world.getJointStates(self.id, self._arm, physicsClientId=self._client)
        return np.array([state[0] for state in states])

    def link_poses(self) -> dict[str, Pose]:
        """Of all links, world frame."""
        states = self._world.getLinkStates(
            self.id, list(self._links.values()), computeForwardKinematics=1, physicsClientId=self._client
        )
        return {name: Pose(state[4], state[5]) for name, state in zip(self._links, states, strict=True)}

    def joint_torques(self) -> Array:
        """Of the arm's motors, as last applied [N m]."""
        states = self._world.getJointStates(self.id, self._arm, physicsClientId=self._client)
        return np.array([state[3] for state in states])

    def all_joints(self) -> dict[str, float]:
        """Of the arm and of the fingers, by the URDF's names [rad] or [m]."""
        states = self._world.getJointStates(
            self.id, [*self._arm, *self._fingers], physicsClientId=self._client
        )
        names = [*self.robot.arm_joints, *(joint.name for joint in self.robot.finger_joints)]
        return {name: state[0] for name, state in zip(names, states, strict=True)}

    def tool_pose(self) -> Pose:
        """Of the tool frame, world frame."""
        state = self._world.getLinkState(
            self.id, self._tool, computeForwardKinematics=1, physicsClientId=self._client
        )
        return Pose(state[4], state[5])

    def finger_width(self) -> float:
        """Between the fingers, from the first finger joint and the last [m]."""
        ends = [self._fingers[0], self._fingers[-1]]
        states = self._world.getJointStates(self.id, ends, physicsClientId=self._client)
        return sum(
            self.gripper.opening_at(state[0], column) for state, column in zip(states, (0, -1), strict=True)
        )

    def pressing(self) -> tuple[dict[int, float], dict[int, float]]:
        """For each side of the hand, the bodies that it presses on, and how hard [N]."""
        left, right = (self._pressing(links) for links in self.gripper.sides)
        return left, right

    def pressed(self) -> set[int]:
        """The other bodies that any link presses on."""
        points = self._world.getContactPoints(bodyA=self.id, physicsClientId=self._client)
        return {point[2] for point in points if point[9] > 0} - {self.id}

    # -- what is done ----------------------------------------------------------------------

    def drive_arm(self, position: Sequence[float], velocity: Sequence[float]) -> None:
        """Set points of the arm's controllers, with velocity feed-forward [rad], [rad/s]."""
        self._world.setJointMotorControlArray(
            self.id,
            self._arm,
            self._world.POSITION_CONTROL,
            targetPositions=position,
            targetVelocities=velocity,
            forces=self._effort,
            positionGains=[POSITION_GAIN] * len(self._arm),
            physicsClientId=self._client,
        )

    def drive_fingers(self, opening: float, force: float, speed: float = CLOSING_SPEED) -> None:
        """Each finger this far from the middle, pressing at most so hard, at most so fast [m], [N], [m/s]."""
        values = self.gripper.values(opening).values()
        forces = self._joint_forces(force)
        for finger, value, rate, share in zip(self._fingers, values, self._rates, forces, strict=True):
            self._world.setJointMotorControl2(
                self.id,
                finger,
                self._world.POSITION_CONTROL,
                targetPosition=value,
                force=share,
                maxVelocity=speed * abs(rate),
                physicsClientId=self._client,
            )

    def close_fingers(self) -> None:
        """Close, and keep pressing."""
        forces = self._joint_forces(GRIP_FORCE)
        for finger, rate, share in zip(self._fingers, self._rates, forces, strict=True):
            self._world.setJointMotorControl2(
                self.id,
                finger,
                self._world.VELOCITY_CONTROL,
                targetVelocity=-CLOSING_SPEED * rate,
                force=share,
                physicsClientId=self._client,
            )

    # -- inside ----------------------------------------------------------------------------

    def _find_joints(self) -> None:
        """PyBullet's indices, by the URDF's names; a link has the index of the joint that carries it."""
        self._links: dict[str, int] = {}
        joints: dict[str, int] = {}
        for index in range(self._world.getNumJoints(self.id, physicsClientId=self._client)):
            told = self._world.getJointInfo(self.id, index, physicsClientId=self._client)
            joints[told[1].decode()], self._links[told[12].decode()] = index, index
        self._arm = [joints[name] for name in self.robot.arm_joints]
        self._fingers = [joints[joint.name] for joint in self.robot.finger_joints]
        self._tool = self._links[self.robot.tool_frame]

    def _go_home(self) -> None:
        home = self.robot.home.tolist()
        opened = self.gripper.maximum_opening
        places = zip(
            [*self._arm, *self._fingers], [*home, *self.gripper.values(opened).values()], strict=True
        )
        for joint, position in places:
            self._world.resetJointState(self.id, joint, position, physicsClientId=self._client)
        for link in sorted(set().union(*self.gripper.sides)):
            for untold in sorted(PADS.keys() - self.robot.contact_of(link)):
                self._world.changeDynamics(
                    self.id, self._links[link], **PADS[untold], physicsClientId=self._client
                )
        for finger, rate in zip(self._fingers[1:], self._rates[1:], strict=True):
            self._gear(finger, rate / self._rates[0])
        self.drive_arm(home, [0.0] * len(home))

    def _gear(self, finger: int, ratio: float) -> None:
        """Fingers that are not geared push what they hold out of the middle."""
        world, client = self._world, self._client
        first, origin = self._fingers[0], [0, 0, 0]
        gear = world.createConstraint(
            self.id,
            first,
            self.id,
            finger,
            world.JOINT_GEAR,
            [1, 0, 0],
            origin,
            origin,
            physicsClientId=client,
        )
        stiffness = SLIDING_GEAR if self.gripper.slides else SWINGING_GEAR
        world.changeConstraint(gear, gearRatio=-1 / ratio, **stiffness, physicsClientId=client)

    def _finger_rates(self) -> list[float]:
        """Change of each finger joint per change of the opening [1] or [rad/m]."""
        gripper = self.gripper
        low, high = gripper.values(0.0), gripper.values(gripper.maximum_opening)
        return [(high[name] - low[name]) / gripper.maximum_opening for name in low]

    def _joint_forces(self, of_finger: float) -> list[float]:
        """Of every finger joint, such that each finger presses as hard as that [N] or [N m].

        Fingers that slide push alike; of hinges in a row the first drives, and the gears do the rest.
        """
        total, count = of_finger * 2.0 / abs(self._rates[0]), len(self._fingers)
        return [total / count] * count if self.gripper.slides else [total, *[0.0] * (count - 1)]

    def _pressing(self, links: frozenset[str]) -> dict[int, float]:
        forces: dict[int, float] = {}
        for link in sorted(links):
            for point in self._world.getContactPoints(
                bodyA=self.id, linkIndexA=self._links[link], physicsClientId=self._client
            ):
                if point[9] > 0 and point[2] != self.id:
                    forces[point[2]] = forces.get(point[2], 0.0) + point[9]
        return forces
