"""What is asked of a scene now and then: does a hand fit there, how far is this from that, what is below."""

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import mujoco
import numpy as np

from kinematics.collision.models import GHOST, NOWHERE_ELSE, TABLE, for_questions
from kinematics.geometry.transforms import Array, Pose, inverse, pose_of, quaternion_from_rotation, wxyz
from kinematics.robot.gripper import gripper_of
from kinematics.robot.robot import Robot
from kinematics.shapes.shapes import Shape

TOUCHING = 1e-4  # [m]
HALVINGS = 8  # of the way between closed and open fingers
SLIMMER = 1.5e-3  # a body that is let down, so that a neighbour at its side does not stop it [m]


class Questions:
    """A model of its own, so that the one that is asked thousands of times stays small."""

    def __init__(
        self, robot: Robot, shapes: Mapping[str, Shape], in_hand: Mapping[Shape, str], margin: float
    ) -> None:
        self._robot, self._shapes = robot, shapes
        self._model = for_questions(robot, shapes, in_hand, margin, SLIMMER)
        self._data = mujoco.MjData(self._model)
        self._geoms = {name: geoms_of(self._model, f"body_{name}") for name in shapes}
        self._held = {shape: geoms_of(self._model, name) for shape, name in in_hand.items()}
        self._is_ghost = self._model.geom_contype == GHOST
        self._ghost = self._data.qpos[robot.dof : robot.dof + 7]
        self._hide_ghost()

    def place_like(self, data: Any) -> None:
        """The bodies where they are in another model's data."""
        self._data.mocap_pos[:] = data.mocap_pos
        self._data.mocap_quat[:] = data.mocap_quat

    def hold(self, shape: Shape, pose: Pose) -> None:
        """A body of that shape in the hand, its pose in the tool frame."""
        body = self._model.geom_bodyid[self._held[shape][0]]
        self._model.body_pos[body] = pose.position
        self._model.body_quat[body] = wxyz(pose.quaternion_xyzw)

    def hand_is_free(self, tool: Array, opening: float, margin: float) -> bool:
        """Whether a hand without an arm keeps the margin."""
        self._show_ghost(tool, opening)
        mujoco.mj_kinematics(self._model, self._data)
        mujoco.mj_collision(self._model, self._data)
        contact = self._data.contact
        near = contact.dist < margin
        is_free = not bool((near & (self._is_ghost[contact.geom].any(axis=1))).any())
        self._hide_ghost()
        return is_free

    def closed_on(self, tool: Array, name: str) -> float:
        """The opening at which the fingers of a hand there would meet a body, were that in the middle [m].

        Not the body's width: fingers are not as wide apart at their tips as they are at the tool.
        """
        fingers = [
            geom
            for links in gripper_of(self._robot).sides
            for link in links
            for geom in geoms_of(self._model, f"ghost_{link}")
        ]
        low, high = 0.0, gripper_of(self._robot).maximum_opening
        for _ in range(HALVINGS):
            middle = (low + high) / 2
            self._show_ghost(tool, middle)
            mujoco.mj_kinematics(self._model, self._data)
            if self._nearest(fingers, self._geoms[name]) > TOUCHING:
                high = middle
            else:
                low = middle
        self._hide_ghost()
        return (low + high) / 2

    def drop_height(self, q: Array, held: str, below: float) -> float:
        """How far the held body can go straight down before it rests on something, at most `below` [m].

        Conservative advancement: the distance to anything is a safe step.
        """
        self._data.qpos[: len(q)] = q
        mujoco.mj_kinematics(self._model, self._data)
        geoms = self._held[self._shapes[held]]
        others = [geom for name in self._shapes if name != held for geom in self._geoms[name]]
        others.append(self._model.geom(f"{TABLE}_top").id)
        return self._advance_down(geoms, others, below + SLIMMER) - SLIMMER

    def distance(self, a: str, b: str) -> float:
        """Between two bodies [m]."""
        mujoco.mj_kinematics(self._model, self._data)
        return self._nearest(self._geoms[a], self._geoms[b])

    def room_of(self, name: str, shifts: Sequence[Array]) -> float:
        """The least distance of a body to all others, were it shifted by any of these [m]."""
        mujoco.mj_kinematics(self._model, self._data)
        geoms = self._geoms[name]
        others = [geom for other in self._shapes if other != name for geom in self._geoms[other]]
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
        others = list(others)
        nearest = 1.0 if others else math.inf
        for a in geoms:
            for b in others:
                is_plane = model.geom_rbound[b] == 0.0
                radii = model.geom_rbound[a] + model.geom_rbound[b]
                if is_plane or math.dist(data.geom_xpos[a], data.geom_xpos[b]) - radii < nearest:
                    found = float(mujoco.mj_geomDistance(model, data, a, b, 1.0, None))
                    nearest = min(nearest, found)
        return nearest

    def _show_ghost(self, tool: Array, opening: float) -> None:
        flange = tool @ inverse(self._robot.tool_to_flange)
        self._ghost[:3] = flange[:3, 3]
        self._ghost[3:] = wxyz(quaternion_from_rotation(flange[:3, :3]))
        place_fingers(self._model, self._robot, opening, "ghost_")

    def _hide_ghost(self) -> None:
        self._ghost[:3] = NOWHERE_ELSE


def place_fingers(model: Any, robot: Robot, opening: float, prefix: str) -> None:
    """The fingers of the arm, or of its ghost, each this far from the middle [m]."""
    for link, transform in gripper_of(robot).link_poses(opening).items():
        body, pose = model.body(prefix + link).id, pose_of(transform)
        model.body_pos[body] = pose.position
        model.body_quat[body] = wxyz(pose.quaternion_xyzw)


def geoms_of(model: Any, body: str) -> Any:
    """Indices of all geoms of a body of a model."""
    first, count = int(model.body(body).geomadr[0]), int(model.body(body).geomnum[0])
    return np.arange(first, first + count)
