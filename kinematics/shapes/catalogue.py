"""Common shapes: meshes from files, prisms, bowls, forks, bins and trays."""

import math
import xml.etree.ElementTree as ElementTree
from pathlib import Path

from kinematics.errors import UnusableShape
from kinematics.geometry import urdf
from kinematics.geometry.meshes import mesh_points
from kinematics.geometry.transforms import Vector, pose_of
from kinematics.shapes.bodies import Colour
from kinematics.shapes.shapes import (
    Box,
    Cavity,
    Compound,
    Convex,
    Cylinder,
    Hull,
    Piece,
    Sphere,
    half_extents_of,
)

HANDLE = "handle"  # how the name of a collision begins that a hand closes on


def hull_from_mesh(path: Path, scale: float = 1.0) -> Hull:
    """Return the convex hull of a mesh file (obj, stl, dae …), about the centre of its bounding box."""
    points = mesh_points(path) * scale
    points = points - (points.min(axis=0) + points.max(axis=0)) / 2
    return Hull(tuple((x, y, z) for x, y, z in points.tolist()))


def hull_of_size(path: Path, size: Vector) -> Hull:
    """Return the convex hull of a mesh file, stretched to a length, width and height [m]."""
    hull = hull_from_mesh(path)
    scale = [full / 2 / half for full, half in zip(size, half_extents_of(hull), strict=True)]
    return Hull(tuple((x * scale[0], y * scale[1], z * scale[2]) for x, y, z in hull.points))


def compound_from_urdf(path: Path) -> Compound:
    """Return the collision geometry of a URDF of one link, about the link's origin.

    A hand closes on the collisions whose names begin with `handle`, or on any where none does.
    """
    description = urdf.read(path)
    pieces: list[Piece] = []
    handles: list[int] = []
    for collision in description.root.iterfind("link/collision"):
        at = pose_of(urdf.origin_of(collision))
        if collision.get("name", "").startswith(HANDLE):
            handles.append(len(pieces))
        pieces.append(Piece(_urdf_shape(collision, path), at.position, at.quaternion_xyzw))
    if not pieces or description.joints:
        raise UnusableShape(f"{path}: expected one link with collision geometry and no joints")
    return Compound(tuple(pieces), tuple(handles))


def mass_from_urdf(path: Path) -> float | None:
    """Return the mass of a URDF of one link [kg], if it has one.

    Raises `UnusableShape` for an impossible one.
    """
    element = urdf.read(path).root.find("link/inertial/mass")
    if element is None:
        return None
    mass = float(element.get("value", "nan"))
    if not 0 < mass < math.inf:
        raise UnusableShape(f"{path}: a mass is a positive number [kg]")
    return mass


def colour_from_urdf(path: Path) -> Colour | None:
    """Return the colour that a URDF of one link has, where it has one."""
    element = urdf.read(path).root.find("link/visual/material/color")
    if element is None:
        return None
    red, green, blue, alpha = (float(word) for word in element.get("rgba", "").split())
    return red, green, blue, alpha


def _urdf_shape(collision: ElementTree.Element, path: Path) -> Convex:
    (geometry,) = collision.iterfind("geometry/*")
    if geometry.tag == "box":
        x, y, z = (float(word) / 2 for word in geometry.get("size", "").split())
        return Box((x, y, z))
    if geometry.tag == "cylinder":
        return Cylinder(float(geometry.get("radius", "0")), float(geometry.get("length", "0")))
    if geometry.tag == "sphere":
        return Sphere(float(geometry.get("radius", "0")))
    if geometry.tag != "mesh":
        raise UnusableShape(f"{path}: <{geometry.tag}> is not a known shape")
    scale = [float(word) for word in geometry.get("scale", "1 1 1").split()]
    points = mesh_points(Path(geometry.get("filename", ""))) * scale
    return Hull(tuple((x, y, z) for x, y, z in points.tolist()))


def prism(sides: int, radius: float, height: float) -> Hull:
    """Return an upright regular prism; `radius` is that of its corners [m]."""
    angles = [2 * math.pi * k / sides for k in range(sides)]
    return Hull(
        tuple(
            (radius * math.cos(a), radius * math.sin(a), z) for z in (-height / 2, height / 2) for a in angles
        )
    )


def bowl(
    radius: float = 0.068, height: float = 0.06, wall: float = 0.004, clearance: float = 0.008
) -> Compound:
    """Return a bowl of a base, a step and twelve wall facets; the step rests on the rim of a like bowl below.

    The origin is at half its height. `radius` is the inner one [m].
    """
    low = -height / 2
    foot = Piece(Cylinder(radius - clearance, 0.008), (0.0, 0.0, low + 0.004))
    step = Piece(Cylinder(radius + wall, 0.006), (0.0, 0.0, low + 0.011))
    tall = height - 0.014
    facets = 12
    half_width = (radius + wall) * math.tan(math.pi / facets)
    walls = []
    for k in range(facets):
        angle = 2 * math.pi * k / facets
        middle = radius + wall / 2
        walls.append(
            Piece(
                Box((wall / 2, half_width, tall / 2)),
                (middle * math.cos(angle), middle * math.sin(angle), low + 0.014 + tall / 2),
                (0.0, 0.0, math.sin(angle / 2), math.cos(angle / 2)),
            )
        )
    inner = radius / math.sqrt(2)
    cavity = Cavity((inner, inner), low + 0.014, height / 2)
    return Compound((foot, step, *walls), tuple(range(2, 2 + facets)), cavity)


def fork(length: float = 0.1, thickness: float = 0.006) -> Compound:
    """Return a fork that lies flat: a handle 9 mm wide along x, with a wider head."""
    head = 0.3 * length
    handle = length - head
    return Compound(
        (
            Piece(Box((handle / 2, 0.0045, thickness / 2)), (-head / 2, 0.0, 0.0)),
            Piece(Box((head / 2, 0.009, thickness / 2)), (handle / 2, 0.0, 0.0)),
        ),
        handles=(0,),
    )


def tub(inner: Vector = (0.1, 0.1, 0.08), wall: float = 0.005) -> Compound:
    """Return an open box (a bin, a tray) by half its inner length and width, and its inner height [m]."""
    x, y, tall = inner
    low = -(tall + wall) / 2
    middle = low + wall + tall / 2
    sides = [
        Piece(Box((wall / 2, y + wall, tall / 2)), (sign * (x + wall / 2), 0.0, middle)) for sign in (1, -1)
    ] + [Piece(Box((x, wall / 2, tall / 2)), (0.0, sign * (y + wall / 2), middle)) for sign in (1, -1)]
    floor = Piece(Box((x + wall, y + wall, wall / 2)), (0.0, 0.0, low + wall / 2))
    return Compound((floor, *sides), tuple(range(1, 5)), Cavity((x, y), low + wall, low + wall + tall))
