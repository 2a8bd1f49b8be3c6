"""Three libraries agree on every arm, and its kinematics are consistent."""

import math
from collections.abc import Iterator
from functools import reduce

import mujoco
import numpy as np
import pybullet
import pytest

from kinematics.geometry.transforms import (
    Array,
    Pose,
    angle_between,
    inverse,
    pose_of,
    quaternion_from_rotation,
    rotation_about,
    rotation_from_quaternion,
    rotation_from_rpy,
    rpy_from_rotation,
    transform_of,
    wxyz,
)
from kinematics.ik.global_ik import InverseKinematics
from kinematics.robot import models
from kinematics.robot.gripper import gripper_of
from kinematics.robot.robot import Robot, load
from kinematics.skills.workspace import workspace_of


@pytest.fixture
def in_bullet(robot: Robot, tmp_path) -> Iterator[tuple[int, int, list[tuple]]]:
    """Return PyBullet's client, body and information on every joint."""
    path = tmp_path / "robot.urdf"
    path.write_text(models.for_bullet(robot, visuals=False))
    client = pybullet.connect(pybullet.DIRECT)
    body = pybullet.loadURDF(str(path), useFixedBase=True, physicsClientId=client)
    count = pybullet.getNumJoints(body, physicsClientId=client)
    yield client, body, [pybullet.getJointInfo(body, k, physicsClientId=client) for k in range(count)]
    pybullet.disconnect(client)


def configurations(robot: Robot, count: int, seed: int = 0) -> Array:
    limits = robot.limits
    return np.random.default_rng(seed).uniform(limits.lower, limits.upper, (count, robot.dof))


def random_rotation(generator: np.random.Generator) -> Array:
    axis = generator.normal(size=3)
    return rotation_about(axis / np.linalg.norm(axis), generator.uniform(-math.pi, math.pi))


def top_down(robot: Robot, generator: np.random.Generator) -> Array:
    yaw = generator.uniform(-math.pi, math.pi)
    tool = np.diag([1.0, -1.0, -1.0, 1.0])
    tool[:2, :2] = [[math.cos(yaw), math.sin(yaw)], [math.sin(yaw), -math.cos(yaw)]]
    (x0, x1), (y0, y1) = workspace_of(robot).region
    tool[:3, 3] = generator.uniform((x0, y0, 0.02), (x1, y1, 0.25))
    return tool


def test_mujoco_and_pinocchio_agree_on_forward_kinematics(robot: Robot) -> None:
    solver, model = InverseKinematics(robot), models.mujoco_model(robot)
    data = mujoco.MjData(model)
    for q in configurations(robot, 50):
        data.qpos[:] = q
        mujoco.mj_kinematics(model, data)
        tool = solver.forward(q)
        assert np.allclose(data.body(robot.tool_frame).xpos, tool[:3, 3], atol=1e-9)
        assert np.allclose(data.body(robot.tool_frame).xmat.reshape(3, 3), tool[:3, :3], atol=1e-9)


def test_bullet_and_pinocchio_agree_on_forward_kinematics(robot: Robot, in_bullet) -> None:
    client, body, infos = in_bullet
    index = {joint[1].decode(): joint[0] for joint in infos}
    link = {joint[12].decode(): joint[0] for joint in infos}[robot.tool_frame]
    solver = InverseKinematics(robot)
    for q in configurations(robot, 50):
        for name, value in zip(robot.arm_joints, q, strict=True):
            pybullet.resetJointState(body, index[name], value, physicsClientId=client)
        state = pybullet.getLinkState(body, link, computeForwardKinematics=1, physicsClientId=client)
        tool = solver.forward(q)
        assert np.allclose(state[4], tool[:3, 3], atol=1e-6)
        assert np.allclose(rotation_from_quaternion(state[5]), tool[:3, :3], atol=1e-6)


def test_the_three_agree_on_the_order_of_joints_and_on_soft_limits(robot: Robot, in_bullet) -> None:
    limits, model = robot.limits, models.mujoco_model(robot)
    arm = models.pinocchio_model(robot)
    assert tuple(arm.names)[1:] == robot.arm_joints
    assert tuple(model.joint(k).name for k in range(model.njnt)) == robot.arm_joints
    names = [joint[1].decode() for joint in in_bullet[2]]
    assert [name for name in names if name in robot.arm_joints] == list(robot.arm_joints)
    assert np.allclose(model.jnt_range, np.stack([limits.lower, limits.upper], 1))
    assert np.allclose(arm.lowerPositionLimit, limits.lower)
    assert np.allclose(arm.upperPositionLimit, limits.upper)
    hard = {joint[1].decode(): joint[8:10] for joint in in_bullet[2]}
    for name, low, high in zip(robot.arm_joints, limits.lower, limits.upper, strict=True):
        assert hard[name][0] - 1e-6 <= low and high <= hard[name][1] + 1e-6


def test_the_panda_has_the_makers_limits() -> None:
    limits = load("panda").limits
    assert limits.lower[0] == -2.8973 and limits.upper[5] == 3.7525


def test_the_jacobian_agrees_with_finite_differences(robot: Robot) -> None:
    step, solver = 1e-6, InverseKinematics(robot)
    for q in configurations(robot, 10):
        jacobian = solver.jacobian(q)
        here = solver.forward(q)
        for joint in range(robot.dof):
            moved = q.copy()
            moved[joint] += step
            change = inverse(here) @ solver.forward(moved)
            linear = change[:3, 3] / step
            skew = (change[:3, :3] - change[:3, :3].T) / (2 * step)
            angular = np.array([skew[2, 1], skew[0, 2], skew[1, 0]])
            assert np.allclose(jacobian[:, joint], [*linear, *angular], atol=1e-5)


def test_inverse_then_forward_kinematics_gives_the_pose_back(robot: Robot) -> None:
    generator, solver = np.random.default_rng(1), InverseKinematics(robot)
    for _ in range(100):
        tool = top_down(robot, generator)
        q = next(solver.solutions(tool, solver.starts(tool, robot.home, seed=0, restarts=20)), None)
        assert q is not None
        reached = solver.forward(q)
        assert np.linalg.norm(reached[:3, 3] - tool[:3, 3]) < 1e-3
        assert angle_between(reached[:3, :3], tool[:3, :3]) < 1e-2
        assert robot.limits.contains(q)


def _to_the_first_joint(robot: Robot) -> list[Array]:
    names = [joint.name for joint in robot.chain]
    return [joint.origin for joint in robot.chain[: names.index(robot.arm_joints[0]) + 1]]


def test_the_posture_that_an_iteration_starts_from_faces_the_target(robot: Robot) -> None:
    solver = InverseKinematics(robot)
    shoulder = reduce(np.matmul, _to_the_first_joint(robot))[:2, 3]
    for seed in range(20):
        tool = top_down(robot, np.random.default_rng(seed))
        posture = solver.forward(solver.posture_facing(tool))
        seen = [each[:2, 3] - shoulder for each in (posture, tool)]
        bearings = [math.atan2(y, x) for x, y in seen]
        assert abs(bearings[0] - bearings[1]) < 1e-3


def test_a_pose_out_of_reach_has_no_solution(robot: Robot) -> None:
    solver = InverseKinematics(robot)
    tool = np.diag([1.0, -1.0, -1.0, 1.0])
    tool[:3, 3] = 1.5, 0.0, 0.3
    assert list(solver.solutions(tool, solver.starts(tool, robot.home, seed=0, restarts=5))) == []


def test_the_gripper_is_measured_from_nearly_closed_to_open(robot: Robot) -> None:
    gripper = gripper_of(robot)
    assert gripper.openings[0] < 1.5e-3 and 0.03 < gripper.maximum_opening < 0.06
    for opening in np.linspace(gripper.openings[0], gripper.maximum_opening, 7):
        values = list(gripper.values(opening).values())
        for joint, value in enumerate(values):
            assert gripper.opening_at(value, joint) == pytest.approx(opening, abs=1e-5)
    assert all("left" in link for link in gripper.sides[0])
    assert all("right" in link for link in gripper.sides[1])


@pytest.mark.parametrize("seed", range(5))
def test_rotations_survive_conversion_to_quaternions_and_angles(seed: int) -> None:
    rotation = random_rotation(np.random.default_rng(seed))
    quaternion = quaternion_from_rotation(rotation)
    assert np.allclose(rotation_from_quaternion(quaternion), rotation)
    assert np.allclose(rotation_from_rpy(rpy_from_rotation(rotation)), rotation)
    pose = Pose((0.1, 0.2, 0.3), quaternion)
    assert np.allclose(transform_of(pose_of(transform_of(pose))), transform_of(pose))
    converted = np.zeros(9)
    mujoco.mju_quat2Mat(converted, np.array(wxyz(quaternion)))
    assert np.allclose(converted.reshape(3, 3), rotation)
