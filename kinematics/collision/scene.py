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
from kinematics.collision.models import MARGIN, ROBOT, SCENE, for_planning, held_body_names
from kinematics.collision.placing import geoms_of, mocap_ids, place_bodies, place_fingers, place_held
from kinematics.collision.scene_state import HeldBody, SceneState
from kinematics.collision.self_contact import always_touching
from kinematics.geometry.transforms import Array
from kinematics.robot.robot import Robot
from kinematics.shapes.bodies import TABLE
from kinematics.shapes.shapes import Shape

TOLERATED_APPROACH = 1e-3  # by which a tolerated pair may come nearer [m]


@dataclass(frozen=True)
class Contact:
    """Two geoms nearer to each other than `MARGIN`."""

    pair: tuple[int, int]
    names: tuple[str, str]
    distance: float  # negative where they overlap [m]


class CollisionScene:
    """Arm, table and the bodies of a cell, by name; the state of the bodies is an argument of every check."""

    def __init__(
        self, robot: Robot, shapes: Mapping[str, Shape], fixed: frozenset[str] = frozenset()
    ) -> None:
        self.robot = robot
        self.shapes = dict(shapes)
        in_hand = held_body_names(self.shapes, fixed)
        self._model = for_planning(robot, self.shapes, in_hand, MARGIN, always_touching(robot))
        self._data = mujoco.MjData(self._model)
        self._q = self._data.qpos[: robot.dof]  # a view, taken once: every check writes to it
        self._mocap = mocap_ids(self._model, self.shapes)
        self._held = {shape: geoms_of(self._model, name) for shape, name in in_hand.items()}
        self._queries = DistanceQueries(robot, self.shapes, in_hand, MARGIN)
        self._shown: SceneState | None = None

    # -- clearance ---------------------------------------------------------------------------

    def clearance(self, q: Array, state: SceneState) -> float:
        """Return the least distance, up to `MARGIN`; negative where bodies overlap [m]."""
        if state is not self._shown:
            self._show(state)
        self._q[:] = q
        mujoco.mj_kinematics(self._model, self._data)
        mujoco.mj_collision(self._model, self._data)
        if self._data.ncon == 0:
            return MARGIN
        if not state.tolerated:
            return float(self._data.contact.dist.min())
        return min((_beyond_tolerated(contact, state) for contact in self._contacts()), default=MARGIN)

    def is_free(self, q: Array, state: SceneState, margin: float = MARGIN) -> bool:
        """Return whether nothing is nearer than the margin [m]."""
        return self.clearance(q, state) >= margin

    def contacts(self, q: Array, state: SceneState) -> list[Contact]:
        """Return every pair nearer than `MARGIN`, for the evidence of a failure."""
        self.clearance(q, state)
        return self._contacts()

    def tolerating(self, q: Array, state: SceneState) -> SceneState:
        """Return the state in which pairs that are near at these joint positions may stay so, not nearer."""
        tolerated: dict[tuple[int, int], float] = {}
        for contact in self.contacts(q, state):
            tolerated[contact.pair] = min(contact.distance, tolerated.get(contact.pair, MARGIN))
        return replace(state, tolerated=tolerated)

    # -- distances ---------------------------------------------------------------------------

    def hand_is_free(self, tool: Array, state: SceneState, margin: float) -> bool:
        """Return whether a hand without an arm, its tool frame there, keeps the margin [m]."""
        return self._queries.hand_is_free(tool, state, margin)

    def contact_opening(self, tool: Array, name: str, state: SceneState) -> float:
        """Return the opening at which the fingers of a hand there would touch a body between them [m]."""
        return self._queries.contact_opening(tool, name, state)

    def drop_height(self, q: Array, state: SceneState, below: float) -> float:
        """Return how far the held body can go down before it rests on something, at most `below` [m]."""
        return self._queries.drop_height(q, state, below)

    def distance(self, a: str, b: str, state: SceneState) -> float:
        """Return the distance between two bodies [m]."""
        return self._queries.distance(a, b, state)

    def distance_to_others(self, name: str, shifts: Sequence[Array], state: SceneState) -> float:
        """Return the least distance of a body to all others, over the shifts [m]."""
        return self._queries.distance_to_others(name, shifts, state)

    # -- inside ------------------------------------------------------------------------------

    def _show(self, state: SceneState) -> None:
        """Move what differs from the state shown."""
        shown, self._shown = self._shown, None
        if shown is None or not state.has_bodies_of(shown):
            place_bodies(self._data, self._mocap, state)
        if shown is None or state.opening != shown.opening:
            place_fingers(self._model, self.robot, state.opening, "")
        if shown is None or state.held != shown.held:
            self._hold(state.held)
        self._shown = state

    def _hold(self, held: HeldBody | None) -> None:
        """Let the held body collide, and none of the others that could be in the hand."""
        held_shape = None if held is None else self.shapes[held.name]
        for shape, geoms in self._held.items():
            active = int(shape == held_shape)
            self._model.geom_contype[geoms] = ROBOT * active
            self._model.geom_conaffinity[geoms] = (ROBOT | SCENE) * active
        if held is not None:
            place_held(self._model, self._held[self.shapes[held.name]], held.pose_in_tool)

    def _contacts(self) -> list[Contact]:
        contacts = []
        for contact in self._data.contact[: self._data.ncon]:
            first, second = int(contact.geom1), int(contact.geom2)
            names = (self._name(first), self._name(second))
            contacts.append(Contact((first, second), names, float(contact.dist)))
        return contacts

    def _name(self, geom: int) -> str:
        body = int(self._model.geom_bodyid[geom])
        name: str = self._model.body(body).name
        return name.removeprefix("body_") if body else TABLE


def _beyond_tolerated(contact: Contact, state: SceneState) -> float:
    tolerated = state.tolerated.get(contact.pair)
    if tolerated is None:
        return contact.distance
    return MARGIN if contact.distance >= tolerated - TOLERATED_APPROACH else contact.distance
