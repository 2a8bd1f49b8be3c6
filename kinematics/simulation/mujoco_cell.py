"""The simulated cell in MuJoCo."""

from collections.abc import Iterable, Sequence
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from kinematics.geometry.transforms import Array, Pose, Vector, wxyz
from kinematics.planning.trajectory import TIME_STEP
from kinematics.robot.robot import Robot
from kinematics.shapes.bodies import TABLE, Body
from kinematics.simulation.mujoco_model import DAMPING, STIFFNESS, SUBSTEPS, cell_model, name_of
from kinematics.simulation.simulated_cell import SimulatedCell

mujoco.set_mju_user_warning(lambda _: None)  # else it writes a file into the user's folder

MODELS = 8  # compiled ones that are kept: the episodes of a task mostly differ in poses alone
_LEAD = DAMPING / STIFFNESS  # of a set point before a moving joint [s]
_PRESSING_BEYOND = 0.02  # how far beyond closed the set point of pressing fingers is: force at its limit [m]
_WORLD = 0  # MuJoCo's body that holds the table


class MujocoCell(SimulatedCell):
    """A robot on a table, with bodies, in MuJoCo."""

    def __init__(self, robot: Robot | None = None) -> None:
        self._models: dict[tuple[object, ...], Any] = {}
        super().__init__(robot)

    def _close(self) -> None:
        self._models.clear()

    # -- measurements ----------------------------------------------------------------------

    def joint_positions(self) -> Array:
        return np.array(self._data.qpos[self._arm])

    def link_poses(self) -> dict[str, Pose]:
        return {name: self._link_pose(link) for name, link in self._links.items()}

    def joint_torques(self) -> Array:
        return np.array(self._data.actuator_force[self._arm_motors])

    def all_joints(self) -> dict[str, float]:
        return dict(zip(self._joint_names, self._data.qpos[self._joints].tolist(), strict=True))

    def tool_pose(self) -> Pose:
        return self._link_pose(self._links[self.robot.tool_frame])

    def pressed(self) -> frozenset[str]:
        return frozenset(self._pressed_by(self._links.values()))

    # -- commands --------------------------------------------------------------------------

    def _drive_arm(self, position: Sequence[float], velocity: Sequence[float]) -> None:
        self._set_point = np.add(position, np.multiply(_LEAD, velocity))

    # -- inside ----------------------------------------------------------------------------

    def _build(self) -> None:
        self._model = self._model_of(tuple(self.bodies.values()))
        self._data: Any = mujoco.MjData(self._model)
        self._find()
        self._go_home()
        self._forces: list[int] = []  # bodies that a force is applied to
        mujoco.mj_forward(self._model, self._data)
        self._moved = False  # since the poses of links were computed
        self._awake: Any = mujoco.MjData(self._model)  # in which nothing sleeps
        self._contact_pairs: NDArray[np.int32] | None = None  # all contacts, once asked for

    def _model_of(self, bodies: tuple[Body, ...]) -> Any:
        key = tuple((b.name, b.shape, b.mass, b.friction, b.is_fixed and b.pose) for b in bodies)
        if key not in self._models:
            if len(self._models) >= MODELS:
                del self._models[next(iter(self._models))]
            self._models[key] = cell_model(self.robot, bodies)
        return self._models[key]

    def _find(self) -> None:
        """Find MuJoCo's indices by name."""
        model = self._model
        joints = [*self.robot.arm_joints, *(joint.name for joint in self.robot.finger_joints)]
        self._joint_names = joints
        self._joints = np.array([int(model.joint(name).qposadr[0]) for name in joints])
        self._motors = np.array([int(model.actuator(name).id) for name in joints])
        self._arm, self._arm_motors = self._joints[: self.robot.dof], self._motors[: self.robot.dof]
        self._fingers, self._finger_motors = self._joints[self.robot.dof :], self._motors[self.robot.dof :]
        names = {model.body(k).name: k for k in range(model.nbody)}
        self._links = {
            link: names[link] for link in self.robot.urdf.links if names.get(link, _WORLD) != _WORLD
        }
        tool = self.robot.tool_frame
        self._links.setdefault(tool, names[tool])
        self._ids = {name: names[name_of(name)] for name in self.bodies}
        self._names = {identity: name for name, identity in self._ids.items()}
        self._sides = [
            frozenset(self._links[link] for link in side if link in self._links)
            for side in self.gripper.sides
        ]
        self._qpos_at = {
            name: int(model.jnt_qposadr[model.body_jntadr[identity]])
            for name, identity in self._ids.items()
            if not self.bodies[name].is_fixed
        }
        self._qvel_at = {
            name: int(model.jnt_dofadr[model.body_jntadr[self._ids[name]]]) for name in self._qpos_at
        }

    def _go_home(self) -> None:
        data = self._data
        fingers = list(self.gripper.values(self.gripper.maximum_opening).values())
        data.qpos[self._joints] = [*self.robot.home.tolist(), *fingers]
        data.ctrl[self._motors] = data.qpos[self._joints]
        self._set_point = self.robot.home
        self._finger_target = np.array(fingers)
        self._finger_steps = np.zeros(len(fingers))
        for name, at in self._qpos_at.items():
            body = self.bodies[name]
            data.qpos[at : at + 3], data.qpos[at + 3 : at + 7] = body.position, wxyz(body.quaternion_xyzw)

    def _advance(self) -> None:
        self._advance_fingers()
        ctrl, motors = self._data.ctrl, self._arm_motors
        change = (self._set_point - ctrl[motors]) / SUBSTEPS
        for _ in range(SUBSTEPS):  # in even steps, as a jerk of the hand moves what it holds
            ctrl[motors] += change
            mujoco.mj_step(self._model, self._data)
        self._moved, self._contact_pairs = True, None
        for identity in self._forces:
            self._data.xfrc_applied[identity] = 0.0
        self._forces.clear()

    def _advance_fingers(self) -> None:
        """Move the fingers' set points towards their targets, each by a step at most."""
        here = self._data.ctrl[self._finger_motors]
        gap = self._finger_target - here
        if gap.any():
            self._data.ctrl[self._finger_motors] = here + np.clip(
                gap, -self._finger_steps, self._finger_steps
            )

    def _pose(self, name: str) -> Pose:
        if name not in self._qpos_at:
            return self.bodies[name].pose
        at = self._qpos_at[name]
        x, y, z, qw, qx, qy, qz = self._data.qpos[at : at + 7].tolist()
        return Pose((x, y, z), (qx, qy, qz, qw))

    def _link_pose(self, link: int) -> Pose:
        """Return the pose of a link; after a step MuJoCo's are those from before it."""
        if self._moved:
            mujoco.mj_kinematics(self._model, self._data)
            self._moved = False
        qw, qx, qy, qz = self._data.xquat[link].tolist()
        x, y, z = self._data.xpos[link].tolist()
        return Pose((x, y, z), (qx, qy, qz, qw))

    def _velocity(self, name: str) -> tuple[Sequence[float], Sequence[float]]:
        if name not in self._qpos_at:
            return (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)
        at = self._qvel_at[name]
        velocity = self._data.qvel[at : at + 6].tolist()
        return velocity[:3], velocity[3:]

    def _touch(self, a: str, b: str) -> bool:
        first, second = (_WORLD if name == TABLE else self._ids[name] for name in (a, b))
        pairs = self._all_contacts()
        return bool(
            (
                ((pairs[:, 0] == first) & (pairs[:, 1] == second))
                | ((pairs[:, 0] == second) & (pairs[:, 1] == first))
            ).any()
        )

    def _all_contacts(self) -> NDArray[np.int32]:
        """Return the two bodies of every contact now (n, 2), of those that sleep, too."""
        if self._contact_pairs is None:
            model, awake = self._model, self._awake
            awake.qpos[:] = self._data.qpos
            enabled, model.opt.enableflags = model.opt.enableflags, 0
            mujoco.mj_kinematics(model, awake)
            mujoco.mj_collision(model, awake)
            model.opt.enableflags = enabled
            self._contact_pairs = _bodies_of(model, awake)
        return self._contact_pairs

    def _pressing(self) -> tuple[dict[str, float], dict[str, float]]:
        left, right = (self._pressed_by(side) for side in self._sides)
        return left, right

    def _pressed_by(self, links: Iterable[int]) -> dict[str, float]:
        """Return the bodies that these links press on, with the forces [N]."""
        among, found = set(links), dict[str, float]()
        force = np.zeros(6)
        for k, (first, second) in enumerate(_bodies_of(self._model, self._data).tolist()):
            other = second if first in among else first if second in among else None
            if other in self._names:
                mujoco.mj_contactForce(self._model, self._data, k, force)
                if force[0] > 0:
                    name = self._names[other]
                    found[name] = found.get(name, 0.0) + float(force[0])
        return found

    def _drive_fingers(self, opening: float, force: float, speed: float) -> None:
        self._command_fingers(list(self.gripper.values(opening).values()), force, speed)

    def _press_fingers(self, force: float, speed: float) -> None:
        closed = self.gripper.values(0.0).values()
        beyond = [v - _PRESSING_BEYOND * rate for v, rate in zip(closed, self.gripper.rates, strict=True)]
        self._command_fingers(beyond, force, speed)

    def _command_fingers(self, values: Sequence[float], force: float, speed: float) -> None:
        """Command the finger joints to values, from where they are."""
        limits = np.array(self.gripper.joint_forces(force))
        self._model.actuator_forcerange[self._finger_motors] = np.column_stack([-limits, limits])
        self._data.ctrl[self._finger_motors] = self._data.qpos[self._fingers]
        self._finger_target = np.array(values)
        self._finger_steps = speed * TIME_STEP * np.abs(self.gripper.rates)

    def _apply_force(self, name: str, force: Vector, at: Vector) -> None:
        if name not in self._qpos_at:
            return
        identity = self._ids[name]
        lever = np.subtract(at, self._data.xipos[identity])
        self._data.xfrc_applied[identity] += [*force, *np.cross(lever, force)]
        self._forces.append(identity)


def _bodies_of(model: Any, data: Any) -> NDArray[np.int32]:
    """Return the two bodies of every contact (n, 2)."""
    bodies: NDArray[np.int32] = model.geom_bodyid[data.contact.geom]
    return bodies
