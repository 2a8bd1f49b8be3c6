"""Peers of our inverse kinematics, as one would use them: mink, pink and PyBullet's own."""

import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import mink
import numpy as np
import pinocchio

from kinematics.bench.measuring import version
from kinematics.geometry.transforms import Array, angle_between, quaternion_from_rotation, wxyz
from kinematics.ik.global_ik import InverseKinematics
from kinematics.robot import models
from kinematics.robot.robot import Robot
from kinematics.simulation import pybullet_loading

PEER_RESTARTS = 20
STEPS = 40  # of differential inverse kinematics before a restart
ITERATIONS = 1000  # of PyBullet's solver
GOOD = (5e-4, 5e-3)  # half the tolerances of the evaluation [m], [rad]

Solve = Callable[[Array, int], Array | None]


def _starts(robot: Robot, seed: int, restarts: int) -> Iterator[Array]:
    yield robot.home.copy()
    generator = np.random.default_rng(seed)
    for _ in range(restarts):
        yield generator.uniform(robot.limits.lower, robot.limits.upper)


def _is_good(error: Array) -> bool:
    return float(np.linalg.norm(error[:3])) < GOOD[0] and float(np.linalg.norm(error[3:])) < GOOD[1]


def mink_with(robot: Robot, restarts: int) -> Solve:
    """Return mink's solver with restarts from random joint positions."""
    model = models.mujoco_model(robot)
    configuration = mink.Configuration(model)
    limits = [mink.ConfigurationLimit(model)]
    task = mink.FrameTask(robot.tool_frame, "body", position_cost=1.0, orientation_cost=1.0)

    def descend(start: Array) -> Array | None:
        configuration.update(start)
        for _ in range(STEPS):
            error = task.compute_error(configuration)
            if _is_good(error):
                return np.array(configuration.q)
            try:
                velocity = mink.solve_ik(
                    configuration, [task], 1.0, solver="daqp", damping=1e-6, limits=limits
                )
            except mink.NoSolutionFound:
                return None
            configuration.integrate_inplace(velocity, 1.0)
        return None

    def solve(target: Array, seed: int) -> Array | None:
        turn = mink.SO3(np.array(wxyz(quaternion_from_rotation(target[:3, :3]))))
        task.set_target(mink.SE3.from_rotation_and_translation(turn, target[:3, 3]))
        found = (descend(start) for start in _starts(robot, seed, restarts))
        return next((q for q in found if q is not None), None)

    return solve


def pink_with_restarts(robot: Robot) -> Solve:
    """Return pink's solver with restarts from random joint positions."""
    import pink

    model = models.pinocchio_model(robot)
    data = model.createData()
    task = pink.FrameTask(robot.tool_frame, position_cost=1.0, orientation_cost=1.0)

    def descend(start: Array) -> Array | None:
        configuration = pink.Configuration(model, data, start)
        for _ in range(STEPS):
            if _is_good(task.compute_error(configuration)):
                return np.array(configuration.q)
            try:
                velocity = pink.solve_ik(
                    configuration, [task], 1.0, solver="daqp", damping=1e-6, safety_break=False
                )
            except pink.exceptions.PinkError:
                return None
            configuration.integrate_inplace(velocity, 1.0)
        return None

    def solve(target: Array, seed: int) -> Array | None:
        task.set_target(pinocchio.SE3(target))
        found = (descend(start) for start in _starts(robot, seed, PEER_RESTARTS))
        return next((q for q in found if q is not None), None)

    return solve


def bullet_with(robot: Robot, restarts: int) -> Solve:
    """Return PyBullet's solver with restarts from random joint positions."""
    world: Any = pybullet_loading.load()
    client = world.connect(world.DIRECT)
    with tempfile.TemporaryDirectory() as folder, pybullet_loading.output_silenced():
        path = Path(folder) / "robot.urdf"
        path.write_text(models.for_bullet(robot, visuals=False))
        body = world.loadURDF(str(path), useFixedBase=True, physicsClientId=client)
    infos = [world.getJointInfo(body, k, client) for k in range(world.getNumJoints(body, client))]
    joints = {joint[1].decode(): joint[0] for joint in infos}
    tool = {joint[12].decode(): joint[0] for joint in infos}[robot.tool_frame]
    moving = [joint[1].decode() for joint in infos if joint[2] != world.JOINT_FIXED]
    arm = [moving.index(name) for name in robot.arm_joints]
    kinematics, limits = InverseKinematics(robot), robot.limits

    def once(target: Array, start: Array) -> Array:
        for name, value in zip(robot.arm_joints, start, strict=True):
            world.resetJointState(body, joints[name], value, physicsClientId=client)
        found = world.calculateInverseKinematics(
            body,
            tool,
            target[:3, 3].tolist(),
            quaternion_from_rotation(target[:3, :3]),
            maxNumIterations=ITERATIONS,
            residualThreshold=1e-5,
            physicsClientId=client,
        )
        return np.array([found[k] for k in arm])

    def solve(target: Array, seed: int) -> Array | None:
        for start in _starts(robot, seed, restarts):
            q = once(target, start)
            reached = kinematics.forward(q)
            distance = float(np.linalg.norm(reached[:3, 3] - target[:3, 3]))
            angle = angle_between(reached[:3, :3], target[:3, :3])
            if distance < 1e-3 and angle < 1e-2 and limits.contains(q):
                return q
        return None

    return solve


INSTALLED: dict[str, Callable[[Robot], Solve]] = {
    "mink": lambda robot: mink_with(robot, 0),
    "mink_with_restarts": lambda robot: mink_with(robot, PEER_RESTARTS),
    "pybullet": lambda robot: bullet_with(robot, 0),
    "pybullet_with_restarts": lambda robot: bullet_with(robot, PEER_RESTARTS),
}
if version("pin-pink"):
    INSTALLED["pink_with_restarts"] = pink_with_restarts
