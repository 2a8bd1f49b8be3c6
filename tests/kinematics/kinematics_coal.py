"""A second collision checker, by Pinocchio and coal, that shares only the description with ours."""

from collections.abc import Mapping
from pathlib import Path

import coal
import numpy as np
import pinocchio

from kinematics.collision.models import TABLE_LOWERED
from kinematics.collision.self_contact import always_touching
from kinematics.geometry.transforms import Array, Pose, transform_of
from kinematics.robot import models
from kinematics.robot.gripper import gripper_of
from kinematics.robot.robot import Robot
from kinematics.shapes.shapes import Box, Cylinder, Shape, Sphere, pieces_of, points_of

HALF_THICKNESS = 0.2  # of the table [m]


class CoalChecker:
    """The arm with open fingers among fixed bodies."""

    def __init__(
        self, robot: Robot, shapes: Mapping[str, Shape], poses: Mapping[str, Pose], folder: Path
    ) -> None:
        path = folder / f"{robot.name}.urdf"
        path.write_text(models.text(models.tree(robot)))
        full = pinocchio.buildModelFromUrdf(str(path))
        geometry = pinocchio.buildGeomFromUrdf(full, str(path), pinocchio.COLLISION)
        opened = pinocchio.neutral(full)
        for name, value in gripper_of(robot).values(gripper_of(robot).maximum_opening).items():
            opened[full.joints[full.getJointId(name)].idx_q] = value
        fingers = [full.getJointId(joint.name) for joint in robot.finger_joints]
        self._model, self._geometry = pinocchio.buildReducedModel(full, geometry, fingers, opened)
        for each in self._geometry.geometryObjects:
            if hasattr(each.geometry, "buildConvexHull"):
                each.geometry.buildConvexHull(True, "Qt")
                each.geometry = each.geometry.convex
        links = list(range(self._geometry.ngeoms))
        world = [self._add_table(), *self._add_bodies(shapes, poses)]
        built = {frozenset(pair) for pair in always_touching(robot)}
        for a in links:
            for b in world:
                if self._parent(a) > 0:
                    self._geometry.addCollisionPair(pinocchio.CollisionPair(a, b))
            for b in links[a + 1 :]:
                if self._matters(a, b, built):
                    self._geometry.addCollisionPair(pinocchio.CollisionPair(a, b))
        self._data, self._found = self._model.createData(), self._geometry.createData()

    def distance(self, q: Array) -> float:
        """Return the least distance of any pair; negative if it overlaps [m]."""
        pinocchio.computeDistances(self._model, self._data, self._geometry, self._found, q)
        return min(result.min_distance for result in self._found.distanceResults)

    def _matters(self, a: int, b: int, built: set[frozenset[str]]) -> bool:
        """Return whether two geoms count: not on one link, on neighbours, or always touching."""
        joints = sorted((self._parent(a), self._parent(b)))
        if joints[0] == joints[1] or self._model.parents[joints[1]] == joints[0]:
            return False
        return frozenset((self._link(a), self._link(b))) not in built

    def _parent(self, geom: int) -> int:
        return int(self._geometry.geometryObjects[geom].parentJoint)

    def _link(self, geom: int) -> str:
        return str(self._geometry.geometryObjects[geom].name.rpartition("_")[0])

    def _add_table(self) -> int:
        slab = coal.Box(4.0, 4.0, 2 * HALF_THICKNESS)
        return self._add("table", slab, np.array([0.0, 0.0, -HALF_THICKNESS - TABLE_LOWERED]), np.eye(3))

    def _add_bodies(self, shapes: Mapping[str, Shape], poses: Mapping[str, Pose]) -> list[int]:
        added = []
        for name, shape in shapes.items():
            for number, piece in enumerate(pieces_of(shape)):
                at = transform_of(poses[name]) @ transform_of(Pose(piece.position, piece.quaternion_xyzw))
                added.append(self._add(f"{name}{number}", _coal(piece.shape), at[:3, 3], at[:3, :3]))
        return added

    def _add(self, name: str, shape: object, position: Array, rotation: Array) -> int:
        placement = pinocchio.SE3(rotation, position)
        return int(self._geometry.addGeometryObject(pinocchio.GeometryObject(name, 0, 0, placement, shape)))


def _coal(shape: Shape) -> object:
    if isinstance(shape, Box):
        return coal.Box(*(2 * half for half in shape.half_extents))
    if isinstance(shape, Cylinder):
        return coal.Cylinder(shape.radius, shape.height)
    if isinstance(shape, Sphere):
        return coal.Sphere(shape.radius)
    vertices = coal.StdVec_Vec3s()
    vertices.extend(points_of(shape))
    return coal.Convex.convexHull(vertices, True, "Qt")
