"""Three readers of one robot agree, and its kinematics are what they say they are."""

import math

import mujoco
import numpy as np
import pybullet
import pytest

from kinematics import robot
from kinematics.geometry import (
    Array,
    Pose,
    angle_between,
    inverse,
    pose_of,
    quaternion_from_rotation,
    rotation_about,
    rotation_from_quaternion,
    transform_of,
    wxyz,
)
from kinematics.inverse import InverseKinematics

SOLVER = InverseKinematics()


def configurations(count: int, seed: int = 0) -> Array:
    limits = robot.limits()
    return np.random.default_rng(seed).uniform(limits.lower, limits.upper, (count, 7))


def random_rotation(generator: np.random.Generator) -> Array:
    axis = generator.normal(size=3)
    return rotation_about(axis / np.linalg.norm(axis), generator.uniform(-math.pi, math.pi))


def top_down(generator: np.random.Generator) -> Array:
    yaw = generator.uniform(-math.pi, math.pi)
    tool = np.diag([1.0, -1.0, -1.0, 1.0])
    tool[:2, :2] = [[math.cos(yaw), math.sin(yaw)], [math.sin(yaw), -math.cos(yaw)]]
    tool[:3, 3] = generator.uniform((0.3, -0.2, 0.02), (0.7, 0.2, 0.4))
    return tool


def test_mujoco_and_pinocchio_agree_on_forward_kinematics() -> None:
    model = robot.mujoco_model()
    data = mujoco.MjData(model)
    for q in configurations(50):
        data.qpos[:] = q
        mujoco.mj_kinematics(model, data)
        tool = SOLVER.forward(q)
        assert np.allclose(data.body(robot.TOOL_FRAME).xpos, tool[:3, 3], atol=1e-9)
        assert np.allclose(data.body(robot.TOOL_FRAME).xmat.reshape(3, 3), tool[:3, :3], atol=1e-9)


def test_bullet_and_pinocchio_agree_on_forward_kinematics() -> None:
    client = pybullet.connect(pybullet.DIRECT)
    body = pybullet.loadURDF(
        str(robot.folder() / "panda.urdf"), useFixedBase=True, physicsClientId=client
    )
    for q in configurations(50):
        for joint in range(7):
            pybullet.resetJointState(body, joint, q[joint], physicsClientId=client)
        state = pybullet.getLinkState(body, 11, computeForwardKinematics=1, physicsClientId=client)
        tool = SOLVER.forward(q)
        assert np.allclose(state[4], tool[:3, 3], atol=1e-6)
        assert np.allclose(rotation_from_quaternion(state[5]), tool[:3, :3], atol=1e-6)
    pybullet.disconnect(client)


def test_mujoco_and_pinocchio_have_the_soft_limits() -> None:
    limits = robot.limits()
    assert np.allclose(robot.mujoco_model().jnt_range, np.stack([limits.lower, limits.upper], 1))
    assert np.allclose(robot.pinocchio_model().lowerPositionLimit, limits.lower)
    assert limits.lower[0] == -2.8973 and limits.upper[5] == 3.7525


def test_the_jacobian_agrees_with_finite_differences() -> None:
    step = 1e-6
    for q in configurations(10):
        jacobian = SOLVER.jacobian(q)
        here = SOLVER.forward(q)
        for joint in range(7):
            moved = q.copy()
            moved[joint] += step
            change = inverse(here) @ SOLVER.forward(moved)
            linear = change[:3, 3] / step
            skew = (change[:3, :3] - change[:3, :3].T) / (2 * step)
            angular = np.array([skew[2, 1], skew[0, 2], skew[1, 0]])
            assert np.allclose(jacobian[:, joint], [*linear, *angular], atol=1e-5)


def test_inverse_then_forward_kinematics_gives_the_pose_back() -> None:
    generator = np.random.default_rng(1)
    for _ in range(100):
        tool = top_down(generator)
        starts = SOLVER.starts(tool, robot.HOME, seed=0, restarts=20)
        q = next(SOLVER.solutions(tool, starts), None)
        assert q is not None
        reached = SOLVER.forward(q)
        assert np.linalg.norm(reached[:3, 3] - tool[:3, 3]) < 1e-3
        assert angle_between(reached[:3, :3], tool[:3, :3]) < 1e-2
        assert robot.limits().contains(q)


def test_a_pose_out_of_reach_has_no_solution() -> None:
    tool = np.diag([1.0, -1.0, -1.0, 1.0])
    tool[:3, 3] = 1.5, 0.0, 0.3
    starts = SOLVER.starts(tool, robot.HOME, seed=0, restarts=5)
    assert list(SOLVER.solutions(tool, starts)) == []


@pytest.mark.parametrize("seed", range(5))
def test_rotations_survive_the_way_through_quaternions(seed: int) -> None:
    rotation = random_rotation(np.random.default_rng(seed))
    quaternion = quaternion_from_rotation(rotation)
    assert np.allclose(rotation_from_quaternion(quaternion), rotation)
    pose = Pose((0.1, 0.2, 0.3), quaternion)
    assert np.allclose(transform_of(pose_of(transform_of(pose))), transform_of(pose))
    converted = np.zeros(9)
    mujoco.mju_quat2Mat(converted, np.array(wxyz(quaternion)))
    assert np.allclose(converted.reshape(3, 3), rotation)
