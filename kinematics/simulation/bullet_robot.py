"""The robot in a PyBullet simulation: set points in, joint states and contacts out."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from kinematics.geometry.transforms import Array, Pose
from kinematics.robot.gripper import gripper_of
from kinematics.robot.robot import Robot
from kinematics.simulation import pybullet_loading

POSITION_GAIN = 0.2
SLIDING_GEAR = {"erp": 0.1, "maxForce": 50}
SWINGING_GEAR = {"erp": 0.8, "maxForce": 1000}  # a chain of hinges gives way otherwise
PADS: dict[str, dict[str, float]] = {  # contact properties of the fingers that the URDF lacks: rubber
    "lateral_friction": {"lateralFriction": 1.0},
    "spinning_friction": {"spinningFriction": 0.1},
    "stiffness": {"contactStiffness": 30000.0, "contactDamping": 1000.0},
    "friction_anchor": {"frictionAnchor": 1},  # without it a held body creeps when the arm is fast
}


class BulletRobot:
    """A newly loaded robot, at home with an open hand."""

    def __init__(self, robot: Robot, world: Any, client: int, urdf: Path) -> None:
        self.robot = robot
        self.gripper = gripper_of(robot)
        self._world, self._client = world, client
        self.id = pybullet_loading.load_arm(world, client, urdf, robot.urdf.path)
        self._find_joints()
        self._effort = robot.limits.effort.tolist()
        self._rates = self.gripper.rates
        self._go_home()

    # -- measurements ----------------------------------------------------------------------

    def joint_positions(self) -> Array:
        """Return the arm's joint positions (dof,) [rad]."""
        states = self._world.getJointStates(self.id, self._arm, physicsClientId=self._client)
        return np.array([state[0] for state in states])

    def link_poses(self) -> dict[str, Pose]:
        """Return the poses of all links, world frame."""
        states = self._world.getLinkStates(
            self.id, list(self._links.values()), computeForwardKinematics=1, physicsClientId=self._client
        )
        return {name: Pose(state[4], state[5]) for name, state in zip(self._links, states, strict=True)}

    def joint_torques(self) -> Array:
        """Return the last torques of the arm's motors (dof,) [N m]."""
        states = self._world.getJointStates(self.id, self._arm, physicsClientId=self._client)
        return np.array([state[3] for state in states])

    def all_joints(self) -> dict[str, float]:
        """Return the positions of arm and finger joints, by the URDF's names [rad] or [m]."""
        states = self._world.getJointStates(
            self.id, [*self._arm, *self._fingers], physicsClientId=self._client
        )
        names = [*self.robot.arm_joints, *(joint.name for joint in self.robot.finger_joints)]
        return {name: state[0] for name, state in zip(names, states, strict=True)}

    def tool_pose(self) -> Pose:
        """Return the pose of the tool frame, world frame."""
        state = self._world.getLinkState(
            self.id, self._tool, computeForwardKinematics=1, physicsClientId=self._client
        )
        return Pose(state[4], state[5])

    def pressing(self) -> tuple[dict[int, float], dict[int, float]]:
        """Return for each side of the hand the bodies that it presses on, with the forces [N]."""
        left, right = (self._pressing(links) for links in self.gripper.sides)
        return left, right

    def pressed(self) -> set[int]:
        """Return the other bodies that any link presses on."""
        points = self._world.getContactPoints(bodyA=self.id, physicsClientId=self._client)
        return {point[2] for point in points if point[9] > 0} - {self.id}

    # -- commands --------------------------------------------------------------------------

    def drive_arm(self, position: Sequence[float], velocity: Sequence[float]) -> None:
        """Set the set points of the arm's controllers, with velocity feed-forward [rad], [rad/s]."""
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

    def drive_fingers(self, opening: float, force: float, speed: float) -> None:
        """Drive each finger to an opening [m] with at most a force [N] and a speed [m/s]."""
        values = self.gripper.values(opening).values()
        forces = self.gripper.joint_forces(force)
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

    def close_fingers(self, force: float, speed: float) -> None:
        """Close the fingers with at most a speed [m/s], and keep pressing with a force each [N]."""
        forces = self.gripper.joint_forces(force)
        for finger, rate, share in zip(self._fingers, self._rates, forces, strict=True):
            self._world.setJointMotorControl2(
                self.id,
                finger,
                self._world.VELOCITY_CONTROL,
                targetVelocity=-speed * rate,
                force=share,
                physicsClientId=self._client,
            )

    # -- inside ----------------------------------------------------------------------------

    def _find_joints(self) -> None:
        """Find PyBullet's indices by the URDF's names; a link has the index of the joint above it."""
        self._links: dict[str, int] = {}
        joints: dict[str, int] = {}
        for index in range(self._world.getNumJoints(self.id, physicsClientId=self._client)):
            info = self._world.getJointInfo(self.id, index, physicsClientId=self._client)
            joints[info[1].decode()], self._links[info[12].decode()] = index, index
        self._arm = [joints[name] for name in self.robot.arm_joints]
        self._fingers = [joints[joint.name] for joint in self.robot.finger_joints]
        self._tool = self._links[self.robot.tool_frame]

    def _go_home(self) -> None:
        home = self.robot.home.tolist()
        fingers = self.gripper.values(self.gripper.maximum_opening).values()
        for joint, position in zip([*self._arm, *self._fingers], [*home, *fingers], strict=True):
            self._world.resetJointState(self.id, joint, position, physicsClientId=self._client)
        for link in sorted(set().union(*self.gripper.sides)):
            for missing in sorted(PADS.keys() - self.robot.contact_of(link)):
                self._world.changeDynamics(
                    self.id, self._links[link], **PADS[missing], physicsClientId=self._client
                )
        for finger, rate in zip(self._fingers[1:], self._rates[1:], strict=True):
            self._gear(finger, rate / self._rates[0])
        self.drive_arm(home, [0.0] * len(home))

    def _gear(self, finger: int, ratio: float) -> None:
        """Couple a finger to the first one: uncoupled fingers push a held body off centre."""
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

    def _pressing(self, links: frozenset[str]) -> dict[int, float]:
        forces: dict[int, float] = {}
        for link in sorted(links):
            for point in self._world.getContactPoints(
                bodyA=self.id, linkIndexA=self._links[link], physicsClientId=self._client
            ):
                if point[9] > 0 and point[2] != self.id:
                    forces[point[2]] = forces.get(point[2], 0.0) + point[9]
        return forces
