"""From a gripper's joint values to its opening and the poses of its finger links.

Measured once on the robot's collision geometry, without further configuration. Fingers may slide or swing,
and joints may mimic one another.
"""

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import mujoco
import numpy as np

from kinematics.errors import UnusableRobot
from kinematics.geometry.transforms import Array, pose_of, wxyz
from kinematics.robot import models
from kinematics.robot.robot import Robot

GRIPPER_SAMPLES = 65  # between the limits of the gripper's joints
PUSHING_BAND = 0.04  # height of the part of the fingers, from their tips, that touches a pushed body [m]
_BEAD = 1e-4  # radius of a sphere in the tool frame, to measure from [m]


@dataclass(frozen=True, eq=False)
class Gripper:
    """Joint values by opening, which is the distance of each finger from the middle [m]."""

    robot: Robot
    openings: Array  # (n,) increasing, from nearly zero [m]
    driven: Array  # (n, d) of the driven joints
    tips: Array  # (n,) of the fingertips beyond the tool, along the approach [m]
    half_sizes: tuple[float, float]  # of the closed fingers along the tool's x and y [m]
    palm_depth: float  # from the closed fingertips back to the palm, along the approach [m]
    sides: tuple[frozenset[str], frozenset[str]]  # links on either side of the middle

    @property
    def maximum_opening(self) -> float:
        """Largest opening [m]."""
        return float(self.openings[-1])

    def beyond_tool(self, narrow: float, wide: float) -> float:
        """Return how far the fingertips, which may swing, extend beyond the tool between two openings [m]."""
        at = np.linspace(narrow, wide, 9)
        return float(np.interp(at, self.openings, self.tips).max())

    @property
    def slides(self) -> bool:
        """Whether the fingers slide; else they swing on hinges."""
        return self.robot.finger_joints[0].type == "prismatic"

    def values(self, opening: float) -> dict[str, float]:
        """Return the values of all finger joints at an opening [m]."""
        columns = [np.interp(opening, self.openings, column) for column in self.driven.T]
        return self.robot.finger_values(np.array(columns))

    @cached_property
    def _columns(self) -> Array:
        """(n, joints) values of all finger joints."""
        return np.array([list(self.robot.finger_values(driven).values()) for driven in self.driven])

    @cached_property
    def rates(self) -> list[float]:
        """Change of each finger joint per change of the opening [1] or [rad/m]."""
        low, high = self.values(0.0), self.values(self.maximum_opening)
        return [(high[name] - low[name]) / self.maximum_opening for name in low]

    def joint_forces(self, of_finger: float) -> list[float]:
        """Return the force of every finger joint for a pressing force of each finger [N] or [N m].

        Sliding fingers share it; of hinges the first drives, and couplings move the others.
        """
        total, count = of_finger * 2.0 / abs(self.rates[0]), len(self.rates)
        return [total / count] * count if self.slides else [total, *[0.0] * (count - 1)]

    def width_at(self, first: float, last: float) -> float:
        """Return the distance between the fingers, at values of the first and the last finger joint [m]."""
        return self.opening_at(first, 0) + self.opening_at(last, -1)

    def opening_at(self, value: float, joint: int) -> float:
        """Return the opening at a value of one finger joint, an index into `Robot.finger_joints` [m]."""
        values = self._columns[:, joint]
        order = slice(None) if values[-1] > values[0] else slice(None, None, -1)
        return float(np.interp(value, values[order], self.openings[order]))

    def link_poses(self, opening: float) -> dict[str, Array]:
        """Return the transform of each finger link to its parent link (4, 4) at an opening [m]."""
        values = self.values(opening)
        return {joint.child: joint.motion(values[joint.name]) for joint in self.robot.finger_joints}


@models.per_robot
def gripper_of(robot: Robot) -> Gripper:
    """Measure the gripper; raise `UnusableRobot` if its joints do not open and close it."""
    hand = _HandModel(robot)
    ends = [_ends(hand, k) for k in range(len(robot.gripper_joints))]
    closed, opened = (np.array([end[k] for end in ends]) for k in (0, 1))
    shares = np.linspace(0.0, 1.0, GRIPPER_SAMPLES)[:, None]
    driven = closed + shares * (opened - closed)  # (GRIPPER_SAMPLES, d)
    gaps = np.array([hand.gap(values) for values in driven])
    first = int(np.flatnonzero(gaps <= gaps.min() + 1e-6)[-1])  # fingers in contact do not close further
    openings, driven = np.maximum(gaps[first:], 0.0), driven[first:]
    if len(openings) < 3 or (np.diff(openings) <= 0).any():
        raise UnusableRobot(
            f"{robot.name}: the gripper joints {list(robot.gripper_joints)} do not open it steadily along "
            f"the tool's closing direction (gaps of {1000 * gaps.min():.1f} to {1000 * gaps.max():.1f} mm); "
            "check 'closing', 'approach' and the position of the tool under [tool]"
        )
    reaches = np.array([float(hand.tips(values)[:, 2].max()) for values in driven])
    closed_tips = hand.tips(driven[0])
    sides = hand.sides(driven[0], driven[-1])
    if not all(sides):
        raise UnusableRobot(
            f"{robot.name}: the fingers are not on either side of the tool along its closing direction; "
            "check 'closing', 'approach' and the position of the tool under [tool]"
        )
    palm_depth = float(closed_tips[:, 2].max()) - hand.palm_reach()
    return Gripper(robot, openings, driven, reaches, _half_sizes(closed_tips), palm_depth, sides)


def _ends(hand: "_HandModel", k: int) -> tuple[float, float]:
    """Return the closed and the open limit of one driven joint, with the others half-way."""
    joints = hand.robot.finger_joints[: len(hand.robot.gripper_joints)]
    low, high = (np.array([getattr(j, end) for j in joints]) for end in ("lower", "upper"))
    gaps = []
    for end in (low, high):
        values = (low + high) / 2
        values[k] = end[k]
        gaps.append(hand.gap(values))
    return (float(low[k]), float(high[k])) if gaps[1] > gaps[0] else (float(high[k]), float(low[k]))


def _half_sizes(tips: Array) -> tuple[float, float]:
    """Return the half extents of closed fingers along the tool's x and y, near their tips [m]."""
    band = tips[tips[:, 2] > tips[:, 2].max() - PUSHING_BAND]
    x, y = np.abs(band[:, :2]).max(axis=0).tolist()
    return x, y


class _HandModel:
    """The arm at home in MuJoCo, with a bead between the fingers."""

    def __init__(self, robot: Robot) -> None:
        self.robot = robot
        spec = models.mujoco_spec(robot)
        bead = mujoco.mjtGeom.mjGEOM_SPHERE
        spec.body(robot.tool_frame).add_geom(name="bead", type=bead, size=[_BEAD, 0, 0])
        self.model = models.compiled(spec, robot)
        self.data = mujoco.MjData(self.model)
        self.data.qpos[:] = robot.home
        fingers = {self.model.body(link).id for link in robot.finger_links}
        self.geoms = [g for g in range(self.model.ngeom) if int(self.model.geom_bodyid[g]) in fingers]
        if not self.geoms:
            listed = ", ".join(robot.finger_links)
            raise UnusableRobot(f"{robot.urdf.path}: no finger has collision geometry, of {listed}")

    def place(self, driven: Array) -> None:
        for joint in self.robot.finger_joints:
            values = self.robot.finger_values(driven)
            body = self.model.body(joint.child).id
            pose = pose_of(joint.motion(values[joint.name]))
            self.model.body_pos[body], self.model.body_quat[body] = pose.position, wxyz(pose.quaternion_xyzw)
        mujoco.mj_kinematics(self.model, self.data)

    def gap(self, driven: Array) -> float:
        """Return the distance from the tool frame's origin to the nearer finger [m]."""
        self.place(driven)
        bead = self.model.geom("bead").id
        nearest: Any = min(
            mujoco.mj_geomDistance(self.model, self.data, bead, geom, 1.0, None) for geom in self.geoms
        )
        return float(nearest) + _BEAD

    def sides(self, closed: Array, opened: Array) -> tuple[frozenset[str], frozenset[str]]:
        """Return the finger links that opening moves along positive, and along negative, y of the tool frame.

        Both empty if opening moves a link farther along x: then the fingers do not close along y.
        """
        left: set[str] = set()
        right: set[str] = set()
        for geom, moved in zip(self.geoms, self._centres(opened) - self._centres(closed), strict=True):
            x, y, _ = moved
            if abs(y) < abs(x):
                return frozenset(), frozenset()
            (left if y > 0 else right).add(self.model.body(self.model.geom_bodyid[geom]).name)
        return frozenset(left), frozenset(right)

    def _centres(self, driven: Array) -> Array:
        """Return the centres of the fingers' geoms (n, 3) in the tool frame [m]."""
        self.place(driven)
        tool = self.data.body(self.robot.tool_frame)
        centres: Array = (self.data.geom_xpos[self.geoms] - tool.xpos) @ tool.xmat.reshape(3, 3)
        return centres

    def tips(self, driven: Array) -> Array:
        """Return the vertices of the fingers (n, 3) in the tool frame [m]."""
        self.place(driven)
        return self._vertices(self.geoms)

    def palm_reach(self) -> float:
        """Return how far the hand without its fingers reaches along the approach, in the tool frame [m]."""
        links = set(self.robot.hand_links) - set(self.robot.finger_links)
        ids = {self.model.body(link).id for link in links}
        bead = self.model.geom("bead").id
        geoms = [g for g in range(self.model.ngeom) if int(self.model.geom_bodyid[g]) in ids and g != bead]
        return float(self._vertices(geoms)[:, 2].max()) if geoms else -math.inf

    def _vertices(self, geoms: list[int]) -> Array:
        """Return the vertices of geoms (n, 3) in the tool frame [m]."""
        tool = self.data.body(self.robot.tool_frame)
        points = []
        for geom in geoms:
            corners = _corners(self.model, geom)
            world = corners @ self.data.geom_xmat[geom].reshape(3, 3).T + self.data.geom_xpos[geom]
            points.append((world - tool.xpos) @ tool.xmat.reshape(3, 3))
        return np.concatenate(points)


def _corners(model: Any, geom: int) -> Array:
    """Return the points that span a geom (n, 3), in its own frame [m]."""
    mesh = int(model.geom_dataid[geom])
    if model.geom_type[geom] == mujoco.mjtGeom.mjGEOM_MESH:
        start, count = int(model.mesh_vertadr[mesh]), int(model.mesh_vertnum[mesh])
        return np.array(model.mesh_vert[start : start + count], dtype=float)
    centre, half = model.geom_aabb[geom][:3], model.geom_aabb[geom][3:]
    signs = np.array(np.meshgrid(*[(-1, 1)] * 3)).reshape(3, -1).T
    return np.asarray(centre + signs * half, dtype=float)
