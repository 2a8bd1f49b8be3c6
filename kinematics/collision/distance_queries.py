"""Rarer queries of a scene: whether a hand fits, how far apart bodies are, how far below is the support."""

import math
from collections.abc import Iterable, Mapping, Sequence

import mujoco

from kinematics.collision.models import GHOST, GHOST_PARKED, for_distances
from kinematics.collision.placing import geoms_of, mocap_ids, place_bodies, place_fingers, place_held
from kinematics.collision.scene_state import SceneState
from kinematics.geometry.transforms import Array, inverse, quaternion_from_rotation, wxyz
from kinematics.robot.gripper import gripper_of
from kinematics.robot.robot import Robot
from kinematics.shapes.bodies import TABLE
from kinematics.shapes.shapes import Shape

ZERO_DISTANCE = 1e-4  # at which a search for contact ends [m]
BISECTIONS = 8  # of the interval between closed and open fingers
SHRINKAGE = 1.5e-3  # of a body being lowered, so that a neighbour at its side does not stop it [m]


class DistanceQueries:
    """Distances in a model of their own, so that the one for collision checks stays small."""

    def __init__(
        self, robot: Robot, shapes: Mapping[str, Shape], in_hand: Mapping[Shape, str], margin: float
    ) -> None:
        self._robot, self._shapes = robot, shapes
        self._model = for_distances(robot, shapes, in_hand, margin, SHRINKAGE)
        self._data = mujoco.MjData(self._model)
        self._mocap = mocap_ids(self._model, shapes)
        self._geoms = {name: geoms_of(self._model, f"body_{name}") for name in shapes}
        self._held = {shape: geoms_of(self._model, name) for shape, name in in_hand.items()}
        self._is_ghost = self._model.geom_contype == GHOST
        self._ghost = self._data.qpos[robot.dof : robot.dof + 7]
        self._hide_ghost()
        self._shown: SceneState | None = None

    def hand_is_free(self, tool: Array, state: SceneState, margin: float) -> bool:
        """Return whether a hand without an arm keeps the margin [m]."""
        self._show(state)
        self._show_ghost(tool, state.opening)
        mujoco.mj_kinematics(self._model, self._data)
        mujoco.mj_collision(self._model, self._data)
        contact = self._data.contact
        near = contact.dist < margin
        is_free = not bool((near & (self._is_ghost[contact.geom].any(axis=1))).any())
        self._hide_ghost()
        return is_free

    def contact_opening(self, tool: Array, name: str, state: SceneState) -> float:
        """Return the opening at which the fingers of a hand there would touch a body between them [m].

        Not half the body's width: fingers are not as far apart at their tips as at the tool.
        """
        self._show(state)
        fingers = [
            geom
            for links in gripper_of(self._robot).sides
            for link in links
            for geom in geoms_of(self._model, f"ghost_{link}")
        ]
        low, high = 0.0, gripper_of(self._robot).maximum_opening
        for _ in range(BISECTIONS):
            middle = (low + high) / 2
            self._show_ghost(tool, middle)
            mujoco.mj_kinematics(self._model, self._data)
            if self._nearest(fingers, self._geoms[name]) > ZERO_DISTANCE:
                high = middle
            else:
                low = middle
        self._hide_ghost()
        return (low + high) / 2

    def drop_height(self, q: Array, state: SceneState, below: float) -> float:
        """Return how far the held body can go down before it rests on something, at most `below` [m].

        Conservative advancement: the least distance to any other body is a safe step.
        """
        assert state.held is not None
        held = state.held.name
        self._show(state)
        self._data.qpos[: len(q)] = q
        mujoco.mj_kinematics(self._model, self._data)
        geoms = self._held[self._shapes[held]]
        others = [geom for name in self._shapes if name != held for geom in self._geoms[name]]
        others.append(self._model.geom(f"{TABLE}_top").id)
        return self._advance_down(geoms, others, below + SHRINKAGE) - SHRINKAGE

    def distance(self, a: str, b: str, state: SceneState) -> float:
        """Return the distance between two bodies [m]."""
        self._show(state)
        mujoco.mj_kinematics(self._model, self._data)
        return self._nearest(self._geoms[a], self._geoms[b])

    def distance_to_others(self, name: str, shifts: Sequence[Array], state: SceneState) -> float:
        """Return the least distance of a body to all others, over the shifts [m]."""
        self._show(state)
        mujoco.mj_kinematics(self._model, self._data)
        geoms = self._geoms[name]
        others = [geom for other in self._shapes if other != name for geom in self._geoms[other]]
        start = self._data.geom_xpos[geoms].copy()
        least = math.inf
        for shift in shifts:
            self._data.geom_xpos[geoms] = start + shift
            least = min(least, self._nearest(geoms, others))
        return least

    def _show(self, state: SceneState) -> None:
        """Move what differs from the state shown; fingers belong to the ghost, which each query places."""
        shown, self._shown = self._shown, None
        if shown is None or not state.has_bodies_of(shown):
            place_bodies(self._data, self._mocap, state)
        if state.held is not None and (shown is None or state.held != shown.held):
            place_held(self._model, self._held[self._shapes[state.held.name]], state.held.pose_in_tool)
        self._shown = state

    def _advance_down(self, geoms: Array, others: list[int], below: float) -> float:
        start = self._data.geom_xpos[geoms].copy()
        dropped = 0.0
        for _ in range(200):
            self._data.geom_xpos[geoms] = start - (0.0, 0.0, dropped)
            nearest = self._nearest(geoms, others)
            if nearest < ZERO_DISTANCE or dropped >= below:
                break
            dropped += nearest
        return min(dropped, below)

    def _nearest(self, geoms: Iterable[int], others: Iterable[int]) -> float:
        """Return the least distance between two groups [m]; bounding spheres rule most pairs out."""
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
        self._ghost[:3] = GHOST_PARKED
