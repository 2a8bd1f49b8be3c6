"""The collision checker: joint positions in, clearance out; arm, hand, held body and scene, in MuJoCo.

One model serves as long as the shapes of the bodies stay the same: bodies are moved, never rebuilt.
Every body of the scene is a mocap body of its own, since a geom moved inside the world body silently
loses its collisions.
"""

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np

from kinematics.collision_model import (
    GHOST,
    NOWHERE,
    NOWHERE_ELSE,
    ROBOT,
    SCENE,
    TABLE,
    compiled,
    in_hand_names,
)
from kinematics.geometry import Array, Pose, inverse, pose_of, quaternion_from_rotation, wxyz
from kinematics.gripper import gripper_of
from kinematics.robot import Robot
from kinematics.shapes import Shape

MARGIN = 0.004  # clearance is measured up to here [m]
TOUCHING = 1e-4  # [m]
SLIMMER = 1.5e-3  # [m]


@dataclass(frozen=True)
class Touch:
    """Two geoms nearer than the margin."""

    pair: tuple[int, int]
    names: tuple[str, str]
    distance: float  # negative where they overlap [m]


class CollisionScene:
    """Arm, table and the bodies of a cell, by name."""

    def __init__(self, robot: Robot, shapes: Mapping[str, Shape]) -> None:
        self.robot = robot
        self.shapes = dict(shapes)
        self._model = compiled(robot, self.shapes, MARGIN, SLIMMER)
        self._data = mujoco.MjData(self._model)
        self._mocap = {name: int(self._model.body(f"body_{name}").mocapid[0]) for name in self.shapes}
        self._geoms = {name: self._geoms_of(f"body_{name}") for name in self.shapes}
        self._held = {shape: self._geoms_of(name) for shape, name in in_hand_names(self.shapes).items()}
        self._thin = {
            shape: self._geoms_of(f"thin_{name}") for shape, name in in_hand_names(self.shapes).items()
        }
        self._ghost_free = slice(robot.dof, robot.dof + 7)
        self._is_ghost = self._model.geom_contype == GHOST
        self._tolerated: dict[tuple[int, int], float] = {}
        self.checks = 0
        self._hide_ghost()
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
                for some in (geoms, self._thin[shape]):
                    body = self._model.geom_bodyid[some[0]]
                    self._model.body_pos[body] = pose.position
                    self._model.body_quat[body] = wxyz(pose.quaternion_xyzw)

    def open_fingers(self, opening: float) -> None:
        """Each finger this far from the middle [m]."""
        self._place_fingers(opening, "")

    # -- clearance ---------------------------------------------------------------------------

    def clearance(self, q: Array) -> float:
        """The least distance at these joint positions, up to `MARGIN`; negative where things overlap [m]."""
        self.checks += 1
        self._data.qpos[: len(q)] = q
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
        self._show_ghost(tool, opening)
        self.checks += 1
        mujoco.mj_kinematics(self._model, self._data)
        mujoco.mj_collision(self._model, self._data)
        contact = self._data.contact
        near = contact.dist < margin
        is_free = not bool((near & (self._is_ghost[contact.geom].any(axis=1))).any())
        self._hide_ghost()
        return is_free

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

    def drop_height(self, q: Array, held: str, below: float) -> float:
        """How far the held body can go straight down before it rests on something, at most `below` [m].

        Conservative advancement: the distance to anything is a safe step. It is a slimmer body that goes
        down, so that a neighbour at its side does not stop it.
        """
        self._data.qpos[: len(q)] = q
        mujoco.mj_kinematics(self._model, self._data)
        geoms = self._thin[self.shapes[held]]
        others = [geom for name in self.shapes if name != held for geom in self._geoms[name]]
        others.append(self._model.geom(f"{TABLE}_top").id)
        return self._advance_down(geoms, others, below + SLIMMER) - SLIMMER

    def distance(self, a: str, b: str) -> float:
        """Between two bodies that are where they were placed [m]."""
        mujoco.mj_kinematics(self._model, self._data)
        return self._nearest(self._geoms[a], self._geoms[b])

    def room_of(self, name: str, shifts: Sequence[Array]) -> float:
        """The least distance of a body to all others, were it shifted by any of these [m]."""
        mujoco.mj_kinematics(self._model, self._data)
        geoms = self._geoms[name]
        others = [geom for other in self.shapes if other != name for geom in self._geoms[other]]
        start = self._data.geom_xpos[geoms].copy()
        room = math.inf
        for shift in shifts:
            self._data.geom_xpos[geoms] = start + shift
            room = min(room, self._nearest(geoms, others))
        return room

    def _advance_down(self, geoms: Array, others: list[int], below: float) -> float:
        start = self._data.geom_xpos[geoms].copy()
        dropped = 0.0
        for _ in range(200):
            self._data.geom_xpos[geoms] = start - (0.0, 0.0, dropped)
            nearest = self._nearest(geoms, others)
            if nearest < TOUCHING or dropped >= below:
                break
            dropped += nearest
        return min(dropped, below)

    def _nearest(self, geoms: Iterable[int], others: Iterable[int]) -> float:
        """The least distance between two groups; spheres around the geoms say which pairs can matter."""
        model, data = self._model, self._data
        nearest = 1.0 if (others := list(others)) else math.inf
        for a in geoms:
            for b in others:
                radii = model.geom_rbound[a] + model.geom_rbound[b]
                is_plane = model.geom_rbound[b] == 0.0
                apart = math.dist(data.geom_xpos[a], data.geom_xpos[b]) - radii
                if is_plane or apart < nearest:
                    found = float(mujoco.mj_geomDistance(model, data, a, b, 1.0, None))
                    nearest = min(nearest, found)
        return nearest

    # -- inside ------------------------------------------------------------------------------

    def _place_fingers(self, opening: float, prefix: str) -> None:
        for link, transform in gripper_of(self.robot).link_poses(opening).items():
            body, pose = self._model.body(prefix + link).id, pose_of(transform)
            self._model.body_pos[body] = pose.position
            self._model.body_quat[body] = wxyz(pose.quaternion_xyzw)

    def _show_ghost(self, tool: Array, opening: float) -> None:
        flange = tool @ inverse(self.robot.tool_to_flange)
        free = self._data.qpos[self._ghost_free]
        free[:3] = flange[:3, 3]
        free[3:] = wxyz(quaternion_from_rotation(flange[:3, :3]))
        self._place_fingers(opening, "ghost_")

    def _hide_ghost(self) -> None:
        self._data.qpos[self._ghost_free][:3] = NOWHERE_ELSE

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

    def _geoms_of(self, body: str) -> Any:
        """Indices of all geoms of a body of the model."""
        first, count = int(self._model.body(body).geomadr[0]), int(self._model.body(body).geomnum[0])
        return np.arange(first, first + count)


def home_is_free(robot: Robot) -> list[tuple[str, str]]:
    """What the arm touches at home, over an empty table; nothing, for a sound description."""
    scene = CollisionScene(robot, {})
    scene.open_fingers(gripper_of(robot).maximum_opening)
    return [touch.names for touch in scene.touches(robot.home) if touch.distance < 0]
