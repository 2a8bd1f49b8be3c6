"""The collision checker: joint positions in, clearance out; arm, hand, held body and scene, in MuJoCo.

One model serves as long as the shapes of the bodies stay the same: bodies are moved, never rebuilt.
Every body of the scene is a mocap body of its own, since a geom moved inside the world body silently
loses its collisions.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import mujoco

from kinematics.collision.distance_queries import Questions, geoms_of, place_fingers
from kinematics.collision.models import MARGIN, NOWHERE, ROBOT, SCENE, TABLE, for_planning, in_hand_names
from kinematics.geometry.transforms import Array, Pose, pose_of, wxyz
from kinematics.robot.robot import Robot
from kinematics.shapes.shapes import Shape


@dataclass(frozen=True)
class Touch:
    """Two geoms nearer than the margin."""

    pair: tuple[int, int]
    names: tuple[str, str]
    distance: float  # negative where they overlap [m]


class CollisionScene:
    """Arm, table and the bodies of a cell, by name."""

    def __init__(
        self, robot: Robot, shapes: Mapping[str, Shape], fixed: frozenset[str] = frozenset()
    ) -> None:
        self.robot = robot
        self.shapes = dict(shapes)
        in_hand = in_hand_names(self.shapes, fixed)
        self._model = for_planning(robot, self.shapes, in_hand, MARGIN)
        self._data = mujoco.MjData(self._model)
        self._q = self._data.qpos[: robot.dof]  # a view, and its place is looked up once
        self._mocap = {name: int(self._model.body(f"body_{name}").mocapid[0]) for name in self.shapes}
        self._held = {shape: geoms_of(self._model, name) for shape, name in in_hand.items()}
        self._questions = Questions(robot, self.shapes, in_hand, MARGIN)
        self._tolerated: dict[tuple[int, int], float] = {}
        self.checks = 0
        self.hold(None)

    # -- the scene ---------------------------------------------------------------------------

    def place(self, poses: Mapping[str, Pose], absent: frozenset[str] = frozenset()) -> None:
        """Put the bodies where they are; those that are absent, out of the way."""
        for name, index in self._mocap.items():
            if name in absent:
                self._data.mocap_pos[index] = NOWHERE
            else:
                self._data.mocap_pos[index] = poses[name].position
                self._data.mocap_quat[index] = wxyz(poses[name].quaternion_xyzw)

    def hold(self, name: str | None, tool_to_body: Array | None = None) -> None:
        """The hand holds the body of this name, at this transform of body to tool; or nothing."""
        held = None if name is None else self.shapes[name]
        for shape, geoms in self._held.items():
            active = int(shape == held)
            self._model.geom_contype[geoms] = ROBOT * active
            self._model.geom_conaffinity[geoms] = (ROBOT | SCENE) * active
            if active and tool_to_body is not None:
                pose = pose_of(tool_to_body)
                body = self._model.geom_bodyid[geoms[0]]
                self._model.body_pos[body] = pose.position
                self._model.body_quat[body] = wxyz(pose.quaternion_xyzw)
                self._questions.hold(shape, pose)

    def open_fingers(self, opening: float) -> None:
        """Each finger this far from the middle [m]."""
        place_fingers(self._model, self.robot, opening, "")

    # -- clearance ---------------------------------------------------------------------------

    def clearance(self, q: Array) -> float:
        """The least distance at these joint positions, up to `MARGIN`; negative where things overlap [m]."""
        self.checks += 1
        self._q[:] = q
        mujoco.mj_kinematics(self._model, self._data)
        mujoco.mj_collision(self._model, self._data)
        if self._data.ncon == 0:
            return MARGIN
        if not self._tolerated:
            return float(self._data.contact.dist.min())
        return min((self._beyond_tolerated(touch) for touch in self._touches()), default=MARGIN)

    def is_free(self, q: Array, margin: float = MARGIN) -> bool:
        """Whether nothing is nearer than the margin."""
        return self.clearance(q) >= margin

    def touches(self, q: Array) -> list[Touch]:
        """Everything nearer than `MARGIN`, for the evidence of a failure."""
        self.clearance(q)
        return self._touches()

    def hand_is_free(self, tool: Array, opening: float, margin: float) -> bool:
        """Whether a hand alone, its tool frame there, keeps the margin: no inverse kinematics needed."""
        self.checks += 1
        return self._asked().hand_is_free(tool, opening, margin)

    def tolerate_here(self, *configurations: Array) -> None:
        """What is near at these joint positions may stay as near (not nearer) until `tolerate_nothing`."""
        tolerated: dict[tuple[int, int], float] = {}
        self._tolerated = {}
        for q in configurations:
            for touch in self.touches(q):
                tolerated[touch.pair] = min(touch.distance, tolerated.get(touch.pair, MARGIN))
        self._tolerated = tolerated

    def tolerate_nothing(self) -> None:
        self._tolerated = {}

    # -- distances ---------------------------------------------------------------------------

    def closed_on(self, tool: Array, name: str) -> float:
        """The opening at which the fingers of a hand there would meet a body [m]."""
        return self._asked().closed_on(tool, name)

    def drop_height(self, q: Array, held: str, below: float) -> float:
        """How far the held body can go straight down before it rests on something, at most `below` [m]."""
        return self._asked().drop_height(q, held, below)

    def distance(self, a: str, b: str) -> float:
        """Between two bodies that are where they were placed [m]."""
        return self._asked().distance(a, b)

    def room_of(self, name: str, shifts: Sequence[Array]) -> float:
        """The least distance of a body to all others, were it shifted by any of these [m]."""
        return self._asked().room_of(name, shifts)

    def _asked(self) -> Questions:
        """The other model, with the bodies where they are in this one."""
        self._questions.place_like(self._data)
        return self._questions

    # -- inside ------------------------------------------------------------------------------

    def _beyond_tolerated(self, touch: Touch) -> float:
        tolerated = self._tolerated.get(touch.pair)
        if tolerated is None:
            return touch.distance
        return MARGIN if touch.distance >= tolerated - 1e-3 else touch.distance

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
