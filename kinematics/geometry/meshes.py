"""From mesh files to convex hulls, and to files that all libraries read the same way."""

import atexit
import shutil
import tempfile
import xml.etree.ElementTree as ElementTree
from functools import cache
from pathlib import Path

import coal
import numpy as np

from kinematics.errors import UnusableRobot
from kinematics.geometry.transforms import Array

_STL_HEADER, _STL_FACE = 84, 50  # of a binary STL [bytes]
_MOST_FACES = 200_000  # MuJoCo's limit


def mesh_points(path: Path) -> Array:
    """Return the vertices of a mesh file's convex hull (n, 3), in the file's units; for COLLADA in metres."""
    loaded = coal.MeshLoader().load(str(path), np.ones(3))
    loaded.buildConvexHull(True, "Qt")
    return np.array(loaded.convex.points()) * (_collada_unit(path) if path.suffix.lower() == ".dae" else 1.0)


def _collada_unit(path: Path) -> float:
    """Return the unit of a COLLADA file's lengths, which coal ignores [m]."""
    unit = ElementTree.parse(path).find("{*}asset/{*}unit")
    return 1.0 if unit is None else float(unit.get("meter", "1"))


@cache
def readable_mesh(path: Path) -> Path:
    """Return the file itself, or a file with its convex hull if not every library can read it."""
    suffix = path.suffix.lower()
    if suffix == ".obj" or suffix == ".stl" and _is_binary(path):
        return path
    try:
        points = mesh_points(path)
    except (ValueError, ElementTree.ParseError) as unexpected:
        raise UnusableRobot(f"no mesh can be read from {path}: {unexpected}") from unexpected
    made = _folder() / f"{readable_mesh.cache_info().currsize}_{path.stem}.obj"
    made.write_text(hull_as_obj(points))
    return made


@cache
def _folder() -> Path:
    """Return this process's folder for hulls; it is removed when the process ends."""
    made = tempfile.mkdtemp(prefix="kinematics_meshes_")
    atexit.register(shutil.rmtree, made, ignore_errors=True)
    return Path(made)


def _is_binary(path: Path) -> bool:
    """Return whether an STL is binary, by its length, since binary ones may begin with 'solid' too."""
    with path.open("rb") as file:
        faces = int.from_bytes(file.read(_STL_HEADER)[-4:], "little")
    return path.stat().st_size == _STL_HEADER + _STL_FACE * faces and faces <= _MOST_FACES


def hull_triangles(points: Array) -> tuple[list[list[float]], list[int]]:
    """Return vertices of the convex hull of points, and its triangles: three indices each, facing outward."""
    from scipy.spatial import ConvexHull

    hull = ConvexHull(points)
    indices: list[int] = []
    for (a, b, c), plane in zip(hull.simplices.tolist(), hull.equations, strict=True):
        outward = float(np.cross(points[b] - points[a], points[c] - points[a]) @ plane[:3]) > 0
        indices += [a, b, c] if outward else [a, c, b]
    return points.tolist(), indices


def hull_as_obj(points: Array) -> str:
    """Return the convex hull of points as the text of a Wavefront file."""
    vertices, indices = hull_triangles(points)
    lines = [f"v {x:.9g} {y:.9g} {z:.9g}" for x, y, z in vertices]
    lines += [f"f {a + 1} {b + 1} {c + 1}" for a, b, c in zip(*[iter(indices)] * 3, strict=True)]
    return "\n".join(lines) + "\n"
