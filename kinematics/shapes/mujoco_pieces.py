"""From a convex piece to a geom of a MuJoCo description."""

from typing import Any

import mujoco

from kinematics.geometry.transforms import wxyz
from kinematics.shapes.shapes import Box, Cylinder, Hull, Piece, Sphere


def add_piece(spec: Any, body: Any, piece: Piece, **options: Any) -> Any:
    """Add a piece to a body as a geom with further options, and return the geom."""
    settings: dict[str, Any] = {
        **options,
        "pos": list(piece.position),
        "quat": list(wxyz(piece.quaternion_xyzw)),
    }
    shape = piece.shape
    if isinstance(shape, Hull):
        mesh = spec.add_mesh(name=f"hull_{len(spec.meshes)}", uservert=[c for p in shape.points for c in p])
        return body.add_geom(type=mujoco.mjtGeom.mjGEOM_MESH, meshname=mesh.name, **settings)
    kind, size = _primitive(shape)
    return body.add_geom(type=kind, size=size, **settings)


def _primitive(shape: Box | Cylinder | Sphere) -> tuple[Any, list[float]]:
    if isinstance(shape, Box):
        return mujoco.mjtGeom.mjGEOM_BOX, list(shape.half_extents)
    if isinstance(shape, Cylinder):
        return mujoco.mjtGeom.mjGEOM_CYLINDER, [shape.radius, shape.height / 2, 0.0]
    return mujoco.mjtGeom.mjGEOM_SPHERE, [shape.radius, 0.0, 0.0]
