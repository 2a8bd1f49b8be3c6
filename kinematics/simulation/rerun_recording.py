"""A recording of a cell for rerun: robot and bodies in three dimensions over time. Needs the extra `viz`."""

import xml.etree.ElementTree as ElementTree
from collections.abc import Callable
from pathlib import Path
from types import TracebackType
from typing import Any

from kinematics.geometry.meshes import hull_triangles
from kinematics.geometry.transforms import Pose, pose_of
from kinematics.geometry.urdf import origin_of
from kinematics.shapes.bodies import TABLE, Body
from kinematics.shapes.shapes import Box, Cylinder, Piece, Sphere, pieces_of, points_of
from kinematics.simulation.camera import TABLE_COLOUR, TABLE_TOP
from kinematics.simulation.simulated_cell import SimulatedCell

APPLICATION = "kinematics"
READABLE = (".obj", ".stl", ".gltf", ".glb")


class Recording:
    """A recording of every frame of the cell while it is open."""

    def __init__(self, cell: SimulatedCell, path: Path) -> None:
        import rerun  # an extra, imported on use

        self._rerun: Any = rerun
        self._cell, self._previous = cell, cell.on_frame
        self._stream = rerun.RecordingStream(APPLICATION)
        self._stream.save(path)
        self._bodies: object = None
        self._log(TABLE, self._shape(TABLE_TOP, TABLE_COLOUR), static=True)
        self._place(TABLE, Pose(TABLE_TOP.position, TABLE_TOP.quaternion_xyzw))
        for link in cell.robot.urdf.root.findall("link"):
            self._show_link(link)

    def __enter__(self) -> "Recording":
        self._cell.on_frame = self._then(self._previous)
        self.frame()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.frame()
        self._cell.on_frame = self._previous
        self._stream.disconnect()

    def frame(self) -> None:
        """Record the cell as it is now."""
        self._stream.set_time("simulated", duration=self._cell.time)
        if self._bodies is not self._cell.bodies:
            self._bodies = self._cell.bodies
            for body in self._cell.bodies.values():
                self._show_body(body)
        for name, pose in self._cell.poses().items():
            self._place(f"bodies/{name}", pose)
        for link, pose in self._cell.link_poses().items():
            self._place(f"robot/{link}", pose)

    def _then(self, previous: Callable[[], None] | None) -> Callable[[], None]:
        def on_frame() -> None:
            self.frame()
            if previous is not None:
                previous()

        return on_frame

    def _show_body(self, body: Body) -> None:
        for number, piece in enumerate(pieces_of(body.shape)):
            entity = f"bodies/{body.name}/{number}"
            self._log(entity, self._shape(piece, body.colour))
            self._place(entity, Pose(piece.position, piece.quaternion_xyzw))

    def _show_link(self, link: ElementTree.Element) -> None:
        for number, visual in enumerate(link.findall("visual")):
            mesh = visual.find("geometry/mesh")
            if mesh is None or Path(mesh.get("filename", "")).suffix.lower() not in READABLE:
                continue
            entity = f"robot/{link.get('name')}/{number}"
            self._log(entity, self._rerun.Asset3D(path=mesh.get("filename")), static=True)
            self._place(entity, pose_of(origin_of(visual)))

    def _shape(self, piece: Piece, colour: tuple[float, ...]) -> Any:
        shape, rerun = piece.shape, self._rerun
        rgba = [int(255 * part) for part in colour]
        if isinstance(shape, Box):
            return rerun.Boxes3D(half_sizes=[shape.half_extents], colors=[rgba], fill_mode="solid")
        if isinstance(shape, Cylinder):
            sizes = {"lengths": [shape.height], "radii": [shape.radius]}
            return rerun.Cylinders3D(**sizes, colors=[rgba], fill_mode="solid")
        if isinstance(shape, Sphere):
            half = (shape.radius,) * 3
            return rerun.Ellipsoids3D(half_sizes=[half], colors=[rgba], fill_mode="solid")
        vertices, indices = hull_triangles(points_of(shape))
        triangles = list(zip(*[iter(indices)] * 3, strict=True))
        return rerun.Mesh3D(
            vertex_positions=vertices, triangle_indices=triangles, vertex_colors=[rgba] * len(vertices)
        )

    def _place(self, entity: str, pose: Pose) -> None:
        quaternion = self._rerun.Quaternion(xyzw=pose.quaternion_xyzw)
        self._log(entity, self._rerun.Transform3D(translation=pose.position, quaternion=quaternion))

    def _log(self, entity: str, what: Any, static: bool = False) -> None:
        self._stream.log(entity, what, static=static)
