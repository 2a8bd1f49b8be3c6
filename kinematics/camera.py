"""Pictures of the cell: joint positions and poses in, pixels out.

A PyBullet client of its own holds the robot's visual meshes, so that the simulation need not load
them.
"""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kinematics import bullet, robot
from kinematics.geometry import Body, Pose

_JOINTS = (0, 1, 2, 3, 4, 5, 6, 9, 10)
_TABLE_HALF_EXTENTS = (0.5, 0.55, 0.02)  # [m]
_TABLE_COLOUR = (0.87, 0.83, 0.76, 1.0)
_OVERSAMPLING = 2


class Camera:
    """A fixed camera in front of the robot, above the table and to one side."""

    def __init__(self) -> None:
        self._bullet: Any = bullet.load()
        self._client: int = self._bullet.connect(self._bullet.DIRECT)
        self._bodies: Mapping[str, Body] = {}
        self._ids: dict[str, int] = {}
        with bullet.output_silenced():
            self._robot = self._bullet.loadURDF(
                str(robot.folder() / "panda.urdf"),
                useFixedBase=True,
                physicsClientId=self._client,
            )
        self._add_box(_TABLE_HALF_EXTENTS, _TABLE_COLOUR, (0.35, 0.0, -0.021))

    def picture(
        self,
        bodies: Mapping[str, Body],
        poses: Mapping[str, Pose],
        joints: Sequence[float],
        width: int,
        height: int,
        smooth: bool,
    ) -> NDArray[np.uint8]:
        """(height, width, 3); smooth ones are rendered larger and averaged, at twice the time."""
        self._show(bodies)
        for joint, position in zip(_JOINTS, joints, strict=True):
            self._bullet.resetJointState(self._robot, joint, position, physicsClientId=self._client)
        for name, identity in self._ids.items():
            self._bullet.resetBasePositionAndOrientation(identity, *poses[name], physicsClientId=self._client)
        if not smooth:
            return self._render(width, height)
        pixels = self._render(width * _OVERSAMPLING, height * _OVERSAMPLING)
        blocks = pixels.reshape(height, _OVERSAMPLING, width, _OVERSAMPLING, 3)
        averaged: NDArray[np.uint8] = blocks.mean(axis=(1, 3)).round().astype(np.uint8)
        return averaged

    def close(self) -> None:
        self._bullet.disconnect(physicsClientId=self._client)

    def _show(self, bodies: Mapping[str, Body]) -> None:
        if bodies is self._bodies:
            return
        for identity in self._ids.values():
            self._bullet.removeBody(identity, physicsClientId=self._client)
        self._ids = {
            name: self._add_box(body.half_extents, body.colour, body.position)
            for name, body in bodies.items()
        }
        self._bodies = bodies

    def _add_box(
        self, half_extents: Sequence[float], colour: Sequence[float], position: Sequence[float]
    ) -> int:
        shape = self._bullet.createVisualShape(
            self._bullet.GEOM_BOX,
            halfExtents=half_extents,
            rgbaColor=colour,
            specularColor=(0.1, 0.1, 0.1),
            physicsClientId=self._client,
        )
        identity: int = self._bullet.createMultiBody(0, -1, shape, position, physicsClientId=self._client)
        return identity

    def _render(self, width: int, height: int) -> NDArray[np.uint8]:
        view = self._bullet.computeViewMatrix((1.5, -0.8, 0.85), (0.36, 0.02, 0.26), (0, 0, 1))
        projection = self._bullet.computeProjectionMatrixFOV(39, width / height, 0.1, 4.0)
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
