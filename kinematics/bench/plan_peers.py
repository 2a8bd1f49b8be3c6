"""Peers of our planner: plain OMPL, and pybullet_planning."""

import shutil
import tempfile
import weakref
from pathlib import Path
from typing import Any

import numpy as np
from ompl import base, geometric, util

from kinematics.bench.cells import half_of
from kinematics.bench.measuring import version
from kinematics.bench.plan_queries import Query, Referee
from kinematics.collision.self_contact import always_touching
from kinematics.geometry.transforms import Array, pose_of
from kinematics.planning.planner import RANGE, RESOLUTION, Validity
from kinematics.robot import models
from kinematics.robot.gripper import gripper_of
from kinematics.robot.robot import Robot
from kinematics.simulation import pybullet_loading
from kinematics.simulation.bullet_bodies import CollisionBodies

TIME_OUT = 5.0  # [s]
FINGERS_OFF = 0.003  # distance of the fingers from a held cube, for a checker that forbids contact [m]


class OmplWithSimplification:
    """RRTConnect, then OMPL's own simplification, with our collision checker."""

    def __init__(self, robot: Robot, referee: Referee) -> None:
        util.setLogLevel(util.LOG_NONE)
        self._robot, self._referee = robot, referee
        bounds = base.RealVectorBounds(robot.dof)
        for joint in range(robot.dof):
            bounds.setLow(joint, float(robot.limits.lower[joint]))
            bounds.setHigh(joint, float(robot.limits.upper[joint]))
        self._space = base.RealVectorStateSpace(robot.dof)
        self._space.setBounds(bounds)
        self._setup = geometric.SimpleSetup(self._space)
        self._valid: Validity = lambda q: True
        self._setup.setStateValidityChecker(lambda state: self._valid(np.array(state[0 : robot.dof])))
        information = self._setup.getSpaceInformation()
        information.setStateValidityCheckingResolution(RESOLUTION / self._space.getMaximumExtent())
        planner = geometric.RRTConnect(information)
        planner.setRange(RANGE)
        self._setup.setPlanner(planner)
        self._setup.setup()

    def plan(self, query: Query) -> Array | None:
        """Return the corners of a path, or None."""
        self._valid = self._referee.validity(query)
        util.RNG.setSeed(query.seed)
        self._setup.clear()
        self._setup.setStartAndGoalStates(self._state(query.start), self._state(query.goal))
        self._setup.solve(base.timedPlannerTerminationCondition(TIME_OUT))
        if not self._setup.haveExactSolutionPath():
            return None
        self._setup.simplifySolution()
        states = self._setup.getSolutionPath().getStates()
        return np.array([list(state[0 : self._robot.dof]) for state in states])

    def _state(self, q: Array) -> Any:
        state = self._space.allocState()
        for joint, value in enumerate(q):
            state[joint] = float(value)
        return state


class PybulletPlanning:
    """The bidirectional RRT with smoothing, called as its documentation does."""

    def __init__(self, robot: Robot, referee: Referee) -> None:
        pybullet_loading.load()
        import pybullet_planning

        self._pp: Any = pybullet_planning
        self._robot = robot
        self._pp.connect(use_gui=False)
        self._client = self._pp.get_client()
        folder = Path(tempfile.mkdtemp(prefix="kinematics_"))
        weakref.finalize(self, shutil.rmtree, folder, ignore_errors=True)
        path = folder / "robot.urdf"
        path.write_text(models.for_bullet(robot, visuals=False))
        self._world: Any = pybullet_loading.load()
        with pybullet_loading.output_silenced():
            self._body = self._world.loadURDF(str(path), useFixedBase=True, physicsClientId=self._client)
        self._joints = [self._pp.joint_from_name(self._body, name) for name in robot.arm_joints]
        self._tool = self._pp.link_from_name(self._body, robot.tool_frame)
        self._always_touching = {
            tuple(self._pp.link_from_name(self._body, name) for name in pair)
            for pair in always_touching(robot)
            if "world" not in pair
        }
        self._hand = [self._pp.link_from_name(self._body, name) for name in robot.hand_links]
        self._always_touching |= {(a, b) for a in self._hand for b in self._hand if a != b}
        self._collision_bodies = CollisionBodies(self._world, self._client, folder)

    def plan(self, query: Query) -> Array | None:
        """Return the corners of a path, or None."""
        pp = self._pp
        bodies = {body.name: self._collision_bodies.add(body) for body in query.bodies}
        try:
            return self._planned(query, bodies)
        finally:
            for body in bodies.values():
                pp.remove_body(body)
            self._collision_bodies.clear()

    def _planned(self, query: Query, bodies: dict[str, int]) -> Array | None:
        pp = self._pp
        gripper = gripper_of(self._robot)
        opening = half_of(self._robot) + FINGERS_OFF if query.held else gripper.maximum_opening
        for name, value in gripper.values(opening).items():
            pp.set_joint_position(self._body, pp.joint_from_name(self._body, name), value)
        pp.set_joint_positions(self._body, self._joints, query.start)
        attachments, touching = [], set()
        if query.held:
            pose = pose_of(query.held_to_tool)
            attachments.append(pp.Attachment(self._body, self._tool, pose, bodies[query.held]))
            attachments[0].assign()
            touching = {((self._body, link), (bodies[query.held], pp.BASE_LINK)) for link in self._hand}
        obstacles = [body for name, body in bodies.items() if name != query.held]
        path = pp.plan_joint_motion(
            self._body,
            self._joints,
            query.goal,
            obstacles=obstacles,
            attachments=attachments,
            self_collisions=True,
            disabled_collisions=self._always_touching,
            extra_disabled_collisions=touching,
        )
        return None if path is None else np.array(path)


INSTALLED: dict[str, Any] = {"ompl_with_simplification": OmplWithSimplification}
if version("pybullet_planning"):
    INSTALLED["pybullet_planning"] = PybulletPlanning
