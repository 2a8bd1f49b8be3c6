"""The collision checker: joint positions and a scene's state in, clearance out, in MuJoCo.

One model serves as long as the shapes of the bodies stay the same: bodies are moved, never rebuilt. It
remembers which state it shows, so that thousands of checks in one state move nothing but the arm.
Every body of the scene is a mocap body of its own, since a geom moved inside the world body silently
loses its collisions.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import mujoco

from kinematics.collision.distance_queries import DistanceQueries
from kinematics.collision.models import MARGIN, ROBOT, SCENE, TABLE, for_planning, in_hand_names
from kinematics.collision.placing import geoms_of, mocap_ids, place_bodies, place_fingers, place_held
from kinematics.collision.scene_state import HeldBody, SceneState
from kinematics.geometry.transforms import Array
from kinematics.robot.robot import Robot
from kinematics.shapes.shapes import Shape


@dataclass(frozen=True)
class Touch:
    """Two geoms nearer than the margin."""

    pair: tuple[int, int]
    names: tuple[str, str]
    distance: float  # negative where they overlap [m]


class CollisionScene:
    """Arm, table and the bodies of a cell, by name. Every check is told the state that it is about."""

    def __init__(
        self, robot: Robot, shapes: Mapping[str, Shape], fixed: frozenset[str] = frozenset()
    ) -> None:
        self.robot = robot
        self.shapes = dict(shapes)
        in_hand = in_hand_names(self.shapes, fixed)
        self._model = for_planning(robot, self.shapes, in_hand, MARGIN)
        self._data = mujoco.MjData(self._model)
        self._q = self._data.qpos[: robot.dof]  # a view, and its place is looked up once
        self._mocap = mocap_ids(self._model, self.shapes)
        self._held = {shape: geoms_of(self._model, name) for shape, name in in_hand.items()}
        self._queries = DistanceQueries(robot, self.shapes, in_hand, MARGIN)
        self._shown: SceneState | None = None

    # -- clearance ---------------------------------------------------------------------------

    def clearance(self, q: Array, state: SceneState) -> float:
        """Return the least distance, up to `MARGIN`; negative where things overlap [m]."""
        if state is not self._shown:
            self._show(state)
        self._q[:] = q
        mujoco.mj_kinematics(self._model, self._data)
        mujoco.mj_collision(self._model, self._data)
        if self._data.ncon == 0:
            return MARGIN
        if not state.tolerated:
            return float(self._data.contact.dist.min())
        return min((_beyond_tolerated(touch, state) for touch in self._touches()), default=MARGIN)

    def is_free(self, q: Array, state: SceneState, margin: float = MARGIN) -> bool:
        """Return whether nothing is nearer than the margin [m]."""
        return self.clearance(q, state) >= margin

    def touches(self, q: Array, state: SceneState) -> list[Touch]:
        """Return everything nearer than `MARGIN`, for the evidence of a failure."""
        self.clearance(q, state)
        return self._touches()

    def tolerating(self, q: Array, state: SceneState) -> SceneState:
        """Return the state in which what is near at these joint positions may be as near, not nearer."""
        tolerated: dict[tuple[int, int], float] = {}
        for touch in self.touches(q, state):
            tolerated[touch.pair] = min(touch.distance, tolerated.get(touch.pair, MARGIN))
        return replace(state, tolerated=tolerated)

    # -- distances ---------------------------------------------------------------------------

    def hand_is_free(self, tool: Array, state: SceneState, margin: float) -> bool:
        """Return whether a hand without an arm, its tool frame there, keeps the margin [m]."""
        return self._queries.hand_is_free(tool, state, margin)

    def closed_on(self, tool: Array, name: str, state: SceneState) -> float:
        """Return the opening at which the fingers of a hand there would meet a body [m]."""
        return self._queries.closed_on(tool, name, state)

    def drop_height(self, q: Array, state: SceneState, below: float) -> float:
        """Return how far the held body can go down before it rests on something, at most `below` [m]."""
        return self._queries.drop_height(q, state, below)

    def distance(self, a: str, b: str, state: SceneState) -> float:
        """Return the distance between two bodies [m]."""
        return self._queries.distance(a, b, state)

    def room_of(self, name: str, shifts: Sequence[Array], state: SceneState) -> float:
        """Return the least distance of a body to all others, were it shifted by any of these [m]."""
        return self._queries.room_of(name, shifts, state)

    # -- inside ------------------------------------------------------------------------------

    def _show(self, state: SceneState) -> None:
        """Move what is not yet as the state says."""
        shown, self._shown = self._shown, None
        if shown is None or not state.has_bodies_of(shown):
            place_bodies(self._data, self._mocap, state)
        if shown is None or state.opening != shown.opening:
            place_fingers(self._model, self.robot, state.opening, "")
        if shown is None or state.held != shown.held:
            self._hold(state.held)
        self._shown = state

    def _hold(self, held: HeldBody | None) -> None:
        """Let the one body in the hand collide, of those that could be there."""
        held_shape = None if held is None else self.shapes[held.name]
        for shape, geoms in self._held.items():
            active = int(shape == held_shape)
            self._model.geom_contype[geoms] = ROBOT * active
            self._model.geom_conaffinity[geoms] = (ROBOT | SCENE) * active
        if held is not None:
            place_held(self._model, self._held[self.shapes[held.name]], held.pose_in_tool)

    def _touches(self) -> list[Touch]:
        touches = []
        for contact in self._data.contact[: self._data.ncon]:
            first, second = int(contact.geom1), int(contact.geom2)
            names = (self._name(first), self._name(second))
            touches.append(Touch((first, second), names, float(contact.dist)))
        return touches

    def _name(self, geom: int) -> str:
        body = int(self._model.geom_bodyid[geom])
        name: str = self._model.body(body).name
        return name.removeprefix("body_") if body else TABLE


def _beyond_tolerated(touch: Touch, state: SceneState) -> float:
    tolerated = state.tolerated.get(touch.pair)
    if tolerated is None:
        return touch.distance
    return MARGIN if touch.distance >= tolerated - 1e-3 else touch.distance
