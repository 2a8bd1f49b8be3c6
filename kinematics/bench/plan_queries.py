"""Pick-and-place queries in crowded cells, with and without a held cube, and the checks of their paths."""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from kinematics.bench.cells import CUBES, crowded, half_of
from kinematics.collision.models import MARGIN
from kinematics.collision.scene import CollisionScene
from kinematics.collision.scene_state import HeldBody, SceneState
from kinematics.errors import UnusableRobot
from kinematics.geometry.transforms import Array, inverse, pose_of, transform_of
from kinematics.grasping.grasps import grasps_by_cost
from kinematics.ik.global_ik import InverseKinematics
from kinematics.planning.planner import Validity
from kinematics.robot.gripper import gripper_of
from kinematics.robot.robot import Robot
from kinematics.shapes.bodies import Body
from kinematics.skills.approach import CLEARANCE
from kinematics.skills.workspace import workspace_of

FINE = 1 / 160  # between two checks of a path, Euclidean over the joints [rad]
QUERY_RESTARTS = 8
MOST_FAILURES = 100  # cells in a row without a query, which mean that the workspace is unusable
OPENING = 0.04  # of each finger, when nothing is held [m]


@dataclass(frozen=True)
class Query:
    """From above one cube to above another, in a cell."""

    bodies: tuple[Body, ...]
    start: Array  # (dof,) [rad]
    goal: Array  # (dof,) [rad]
    held: str | None
    held_to_tool: Array  # (4, 4)
    seed: int


class Referee:
    """The collision checks of queries and of their paths."""

    def __init__(self, robot: Robot) -> None:
        self.robot = robot
        self._scenes: dict[tuple[Any, ...], CollisionScene] = {}

    def validity(self, query: Query, margin: float = MARGIN) -> Validity:
        """Return the check whether joint positions keep a margin [m] in a query's scene."""
        scene, state = self._scene(query), self._state(query)
        return lambda q: scene.is_free(q, state, margin)

    def _scene(self, query: Query) -> CollisionScene:
        shapes = {body.name: body.shape for body in query.bodies}
        key = tuple(shapes.items())
        if key not in self._scenes:
            fixed = frozenset(body.name for body in query.bodies if body.is_fixed)
            self._scenes[key] = CollisionScene(self.robot, shapes, fixed)
        return self._scenes[key]

    def _state(self, query: Query) -> SceneState:
        poses = {body.name: body.pose for body in query.bodies}
        if query.held is None:
            return SceneState(poses, min(OPENING, gripper_of(self.robot).maximum_opening))
        held = HeldBody(query.held, pose_of(query.held_to_tool))
        return SceneState(poses, half_of(self.robot)).with_held(held)

    def is_clear(self, query: Query, corners: Array) -> bool:
        """Return whether a chain touches nothing, checked every `FINE`."""
        return all(map(self.validity(query, margin=0.0), densified(corners)))


def random_queries(robot: Robot, referee: Referee, seed: int) -> Iterator[Query]:
    """Yield any number of queries whose ends are free; in every second one the hand holds a cube."""
    solver = InverseKinematics(robot)
    number, failures = 0, 0
    while failures < MOST_FAILURES:
        generator = np.random.default_rng((seed, number))
        number += 1
        bodies = tuple(crowded(robot, generator, CUBES))
        first, second = generator.permutation(len(bodies) - 2)[:2]
        held = f"cube{first}" if number % 2 else None
        tools = [_above(robot, bodies[k]) for k in (first, second)]
        in_hand = np.eye(4)
        if held:
            in_hand = inverse(tools[0]) @ transform_of(bodies[first].pose)
            in_hand[:3, 3] = 0.0
        blank = Query(bodies, robot.home, robot.home, held, in_hand, number)
        valid = referee.validity(blank)
        ends = [_free_end(solver, valid, tool, number) for tool in tools]
        failures += 1
        if ends[0] is not None and ends[1] is not None:
            failures = 0
            yield Query(bodies, ends[0], ends[1], held, in_hand, number)
    raise UnusableRobot(
        f"{robot.name}: {MOST_FAILURES} times in a row the tool could not reach above two bodies in its "
        f"workspace {workspace_of(robot).region}; give another `workspace`, or none to have it measured"
    )


def densified(corners: Array) -> Iterator[Array]:
    """Yield points of a chain that are at most `FINE` apart."""
    yield corners[0]
    for a, b in zip(corners, corners[1:], strict=False):
        steps = max(1, math.ceil(float(np.linalg.norm(b - a)) / FINE))
        for k in range(1, steps + 1):
            yield a + (b - a) * (k / steps)


def _above(robot: Robot, body: Body) -> Array:
    grasp = next(grasps_by_cost(body.pose, body.shape, gripper_of(robot)))[0]
    tool = grasp.tool.copy()
    tool[2, 3] = 2 * half_of(robot) + CLEARANCE
    return tool


def _free_end(solver: InverseKinematics, valid: Validity, tool: Array, seed: int) -> Array | None:
    starts = solver.starts(tool, solver.robot.home, seed, QUERY_RESTARTS)
    return next((q for q in solver.solutions(tool, starts) if valid(q)), None)
