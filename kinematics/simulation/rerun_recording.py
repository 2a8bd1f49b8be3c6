"""A cell in motion as a file that rerun opens: robot and bodies in 3-D, to turn about and to wind back.

Needs the extra `viz`.
"""

import xml.etree.ElementTree as ElementTree
from collections.abc import Callable
from pathlib import Path
from types import TracebackType
from typing import Any

from kinematics.geometry.meshes import hull_triangles
from kinematics.geometry.transforms import Pose, pose_of
from kinematics.geometry.urdf import origin_of
from kinematics.shapes.bodies import Body
from kinematics.shapes.shapes import Box, Cylinder, Piece, Sphere, pieces_of, points_of
from kinematics.simulation.workcell import Workcell

APPLICATION = "kinematics"
READABLE = (".obj", ".stl", ".gltf", ".glb")
TABLE = Box((0.5, 0.55, 0.002))


class Recording:
    """While it is open, every frame of the cell goes into the file."""

    def __init__(self, cell: Workcell, path: Path) -> None:
        import rerun  # an extra; imported when it is asked for

        self._rerun: Any = rerun
        self._cell, self._watched = cell, cell.on_frame
        self._stream = rerun.RecordingStream(APPLICATION)
        self._stream.save(path)
        self._bodies: object = None
        self._log("table", self._shape(Piece(TABLE), (0.87, 0.83, 0.76, 1.0)), static=True)
        self._place("table", Pose((0.35, 0.0, -0.002), (0.0, 0.0, 0.0, 1.0)))
        for link in cell.robot.urdf.root.findall("link"):
            self._show_link(link)

    def __enter__(self) -> "Recording":
        self._cell.on_frame = self._both(self._watched)
        self.frame()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.frame()
        self._cell.on_frame = self._watched
        self._stream.disconnect()

    def frame(self) -> None:
        """The cell as it is now."""
        self._stream.set_time("simulated", duration=self._cell.time)
        if self._bodies is not self._cell.bodies:
            self._bodies = self._cell.bodies
            for body in self._cell.bodies.values():
                self._show_body(body)
        for name, pose in self._cell.poses().items():
            self._place(f"bodies/{name}", pose)
        for link, pose in self._cell.link_poses().items():
            self._place(f"robot/{link}", pose)

    def _both(self, other: Callable[[], None] | None) -> Callable[[], None]:
        def called() -> None:
            self.frame()
            if other is not None:
                other()

        return called

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
        told = [int(255 * part) for part in colour]
        if isinstance(shape, Box):
            return rerun.Boxes3D(half_sizes=[shape.half_extents], colors=[told], fill_mode="solid")
        if isinstance(shape, Cylinder):
            sizes = {"lengths": [shape.height], "radii": [shape.radius]}
            return rerun.Cylinders3D(**sizes, colors=[told], fill_mode="solid")
        if isinstance(shape, Sphere):
            half = (shape.radius,) * 3
            return rerun.Ellipsoids3D(half_sizes=[half], colors=[told], fill_mode="solid")
        vertices, indices = hull_triangles(points_of(shape))
        triangles = list(zip(*[iter(indices)] * 3, strict=True))
        return rerun.Mesh3D(
            vertex_positions=vertices, triangle_indices=triangles, vertex_colors=[told] * len(vertices)
        )

    def _place(self, entity: str, pose: Pose) -> None:
        turn = self._rerun.Quaternion(xyzw=pose.quaternion_xyzw)
        self._log(entity, self._rerun.Transform3D(translation=pose.position, quaternion=turn))

    def _log(self, entity: str, what: Any, static: bool = False) -> None:
        self._stream.log(entity, what, static=static)
