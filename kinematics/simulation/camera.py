"""Pictures of the cell: joint positions and poses in, pixels out.

A PyBullet client of its own holds the robot's visual meshes, so that the simulation need not load
them.
"""

import itertools
import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kinematics.geometry.transforms import Array, Pose, Vector, pose_of, transform_of
from kinematics.robot import models
from kinematics.robot.robot import Robot
from kinematics.shapes.bodies import Body
from kinematics.shapes.shapes import Box, Piece, half_extents_of, pieces_of
from kinematics.simulation import pybullet_loading
from kinematics.simulation.bullet_bodies import add_visual_body

TABLE_TOP = Piece(Box((0.5, 0.55, 0.02)), (0.35, 0.0, -0.021))
TABLE_COLOUR = (0.87, 0.83, 0.76, 1.0)
_OVERSAMPLING = 2
_EYE, _TARGET = np.array([1.5, -0.8, 0.85]), np.array([0.36, 0.02, 0.26])  # world frame [m]
_UP = (0.0, 0.0, 1.0)
_VIEW_ANGLE, _NEAR, _FAR = 39.0, 0.1, 6.0  # vertical [degree]; [m]
_DISTANCES = (1.0, 1.1, 1.2, 1.3, 1.4, 1.6)  # of the eye from its target, relative to `_EYE`
_INSIDE = 0.97  # share of half the picture, from the centre, in which everything must be


class Camera:
    """A camera in front of the robot, above the table and to one side, as far back as the bodies need."""

    def __init__(self, robot: Robot) -> None:
        self._bullet: Any = pybullet_loading.load()
        self._client: int = self._bullet.connect(self._bullet.DIRECT)
        self._bodies: Mapping[str, Body] = {}
        self._eye = _EYE
        self._visuals: dict[str, list[tuple[int, Array]]] = {}  # identity, and piece to body (4, 4)
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "robot.urdf"
            path.write_text(models.for_bullet(robot, visuals=True), encoding="utf-8")
            self._robot = pybullet_loading.load_arm(self._bullet, self._client, path, robot.urdf.path)
        self._joints = self._joint_indices()
        add_visual_body(self._bullet, self._client, TABLE_TOP, TABLE_COLOUR)

    def picture(
        self,
        bodies: Mapping[str, Body],
        poses: Mapping[str, Pose],
        joints: Mapping[str, float],
        width: int,
        height: int,
        smooth: bool,
    ) -> NDArray[np.uint8]:
        """Return a picture (height, width, 3); a smooth one is averaged from a larger one: twice the time."""
        self._show(bodies, poses, width / height)
        for name, position in joints.items():
            joint = self._joints[name]
            self._bullet.resetJointState(self._robot, joint, position, physicsClientId=self._client)
        for name, pieces in self._visuals.items():
            body = transform_of(poses[name])
            for identity, piece in pieces:
                pose = pose_of(body @ piece)
                self._bullet.resetBasePositionAndOrientation(identity, *pose, physicsClientId=self._client)
        if not smooth:
            return self._render(width, height)
        pixels = self._render(width * _OVERSAMPLING, height * _OVERSAMPLING)
        blocks = pixels.reshape(height, _OVERSAMPLING, width, _OVERSAMPLING, 3)
        averaged: NDArray[np.uint8] = blocks.mean(axis=(1, 3)).round().astype(np.uint8)
        return averaged

    def close(self) -> None:
        """Disconnect from PyBullet."""
        self._bullet.disconnect(physicsClientId=self._client)

    def _show(self, bodies: Mapping[str, Body], poses: Mapping[str, Pose], aspect: float) -> None:
        if bodies is self._bodies:
            return
        corners = [_corners(pose, half_extents_of(bodies[name].shape)) for name, pose in poses.items()]
        self._eye = self._eye_showing(np.concatenate([np.empty((0, 3)), *corners]), aspect)
        for identity, _ in [piece for pieces in self._visuals.values() for piece in pieces]:
            self._bullet.removeBody(identity, physicsClientId=self._client)
        self._visuals = {
            name: [self._add(piece, body) for piece in pieces_of(body.shape)] for name, body in bodies.items()
        }
        self._bodies = bodies

    def _eye_showing(self, points: Array, aspect: float) -> Array:
        """Return the nearest position of the eye with all points (n, 3) in the picture, or the farthest."""
        homogeneous = np.column_stack([points, np.ones(len(points))])
        for factor in _DISTANCES:
            eye: Array = _TARGET + factor * (_EYE - _TARGET)
            view, projection = (np.array(m).reshape(4, 4) for m in self._matrices(eye, aspect))
            clip = homogeneous @ view @ projection
            if (np.abs(clip[:, :2]) < _INSIDE * clip[:, 3:]).all():
                return eye
        return eye

    def _matrices(self, eye: Array, aspect: float) -> tuple[Any, Any]:
        """Return the matrices of view and projection, column by column as in OpenGL."""
        view = self._bullet.computeViewMatrix(eye.tolist(), _TARGET.tolist(), _UP)
        return view, self._bullet.computeProjectionMatrixFOV(_VIEW_ANGLE, aspect, _NEAR, _FAR)

    def _add(self, piece: Piece, body: Body) -> tuple[int, Array]:
        identity = add_visual_body(self._bullet, self._client, piece, body.colour)
        return identity, transform_of(Pose(piece.position, piece.quaternion_xyzw))

    def _joint_indices(self) -> dict[str, int]:
        count = self._bullet.getNumJoints(self._robot, physicsClientId=self._client)
        infos = [
            self._bullet.getJointInfo(self._robot, k, physicsClientId=self._client) for k in range(count)
        ]
        return {info[1].decode(): info[0] for info in infos}

    def _render(self, width: int, height: int) -> NDArray[np.uint8]:
        view, projection = self._matrices(self._eye, width / height)
        image = self._bullet.getCameraImage(
            width,
            height,
            view,
            projection,
            lightDirection=(0.8, -0.9, 1.8),
            shadow=0,
            lightAmbientCoeff=0.55,
            lightDiffuseCoeff=0.5,
            lightSpecularCoeff=0.05,
            flags=self._bullet.ER_NO_SEGMENTATION_MASK,
            renderer=self._bullet.ER_TINY_RENDERER,
            physicsClientId=self._client,
        )
        return np.asarray(image[2], dtype=np.uint8).reshape(height, width, 4)[:, :, :3]


def _corners(pose: Pose, half: Vector) -> Array:
    """Return the corners of the box around a body (8, 3), world frame [m]."""
    signs = np.array(list(itertools.product((-1.0, 1.0), repeat=3)))
    body = transform_of(pose)
    corners: Array = (signs * half) @ body[:3, :3].T + body[:3, 3]
    return corners
