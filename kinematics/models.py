"""The one description of a robot, as Pinocchio, MuJoCo (for mink too) and PyBullet take it."""

import copy
import xml.etree.ElementTree as ElementTree
from functools import cache
from pathlib import Path
from typing import Any

import coal
import mujoco
import numpy as np
import pinocchio

from kinematics.geometry import Array, rpy_from_rotation
from kinematics.reasons import UnusableRobot
from kinematics.robot import TOOL_LINK, Robot

Element = ElementTree.Element

_READ_BY_ALL = (".obj", ".stl")


def tree(robot: Robot) -> Element:
    """The URDF with absolute paths, and with a link in the tool's frame."""
    root = copy.deepcopy(robot.urdf.root)
    if robot.tool_frame == TOOL_LINK:
        _add_tool(root, robot)
    return root


def text(root: Element) -> str:
    return ElementTree.tostring(root, encoding="unicode")


def for_bullet(robot: Robot, visuals: bool) -> str:
    """Without visuals loading is six times faster."""
    root = tree(robot)
    if not visuals:
        _drop(root, "visual")
    return text(root)


def with_fixed_fingers(robot: Robot) -> Element:
    """Without the finger joints, which as mimics would cost equalities in every update."""
    root = tree(robot)
    _drop(root, "visual")
    for joint in root.findall("joint"):
        for mimic in joint.findall("mimic"):
            joint.remove(mimic)
        if joint.get("name") not in robot.arm_joints:
            joint.set("type", "fixed")
    return root


@cache
def pinocchio_model(robot: Robot) -> Any:
    """The arm alone, within its soft limits."""
    model = pinocchio.buildModelFromXML(text(with_fixed_fingers(robot)))
    found = tuple(name for name in model.names if name != "universe")
    if found != robot.arm_joints:
        raise UnusableRobot(f"{robot.urdf.path}: Pinocchio orders the joints {found}")
    model.lowerPositionLimit = robot.limits.lower.copy()
    model.upperPositionLimit = robot.limits.upper.copy()
    return model


@cache
def mujoco_model(robot: Robot) -> Any:
    """The arm alone, for mink."""
    return mujoco_spec(robot).compile()


def mujoco_spec(robot: Robot) -> Any:
    """The arm with fixed fingers as an editable MuJoCo description, joint ranges tightened.

    Meshes are handed over under names of our own: MuJoCo takes two files of one name for one.
    """
    root = with_fixed_fingers(robot)
    assets: dict[str, bytes] = {}
    for mesh in root.iter("mesh"):
        suffix, content = _mesh_content(Path(mesh.get("filename", "")))
        name = f"mesh{len(assets)}{suffix}"
        assets[name] = content
        mesh.set("filename", name)
    for link in root.findall("link"):
        for number, collision in enumerate(link.findall("collision")):
            collision.set("name", f"{link.get('name')}/{number}")
    options = ElementTree.Element("mujoco")
    settings = {
        "strippath": "false",
        "balanceinertia": "true",
        "discardvisual": "true",
        "fusestatic": "false",
        "inertiafromgeom": "auto",
    }
    ElementTree.SubElement(options, "compiler", settings)
    root.insert(0, options)
    for extra in [e for e in root if e.tag not in ("mujoco", "link", "joint", "material")]:
        root.remove(extra)
    try:
        spec = mujoco.MjSpec.from_string(text(root), assets=assets)
    except ValueError as unexpected:
        raise UnusableRobot(f"{robot.urdf.path}: MuJoCo cannot read it: {unexpected}") from unexpected
    limits = robot.limits
    for name, lower, upper in zip(robot.arm_joints, limits.lower, limits.upper, strict=True):
        spec.joint(name).limited = mujoco.mjtLimited.mjLIMITED_TRUE
        spec.joint(name).range = [lower, upper]
    return spec


def mesh_points(path: Path) -> Array:
    """(n, 3) vertices of a mesh file's convex hull, in its own units."""
    loaded = coal.MeshLoader().load(str(path), np.ones(3))
    loaded.buildConvexHull(True, "Qt")
    return np.array(loaded.convex.points())


def _mesh_content(path: Path) -> tuple[str, bytes]:
    """As MuJoCo reads it; what it does not read becomes the points of its convex hull."""
    if path.suffix.lower() in _READ_BY_ALL:
        return path.suffix.lower(), path.read_bytes()
    return ".obj", hull_as_obj(mesh_points(path)).encode()


def hull_triangles(points: Array) -> tuple[list[list[float]], list[int]]:
    """Vertices of the convex hull of points, and its triangles, three indices each, seen from outside."""
    from scipy.spatial import ConvexHull

    hull = ConvexHull(points)
    indices: list[int] = []
    for (a, b, c), plane in zip(hull.simplices.tolist(), hull.equations, strict=True):
        outward = float(np.cross(points[b] - points[a], points[c] - points[a]) @ plane[:3]) > 0
        indices += [a, b, c] if outward else [a, c, b]
    return points.tolist(), indices


def hull_as_obj(points: Array) -> str:
    """The convex hull of points as a Wavefront file."""
    vertices, indices = hull_triangles(points)
    lines = [f"v {x:.9g} {y:.9g} {z:.9g}" for x, y, z in vertices]
    lines += [f"f {a + 1} {b + 1} {c + 1}" for a, b, c in zip(*[iter(indices)] * 3, strict=True)]
    return "\n".join(lines) + "\n"


def _drop(root: Element, tag: str) -> None:
    for link in root.findall("link"):
        for element in link.findall(tag):
            link.remove(element)


def _add_tool(root: Element, robot: Robot) -> None:
    """A link without weight: PyBullet gives a kilogram to what does not say its mass."""
    link = ElementTree.SubElement(root, "link", {"name": TOOL_LINK})
    inertial = ElementTree.SubElement(link, "inertial")
    ElementTree.SubElement(inertial, "mass", {"value": "0.0"})
    inertia = {key: "0.1" if key[1] == key[2] else "0" for key in ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")}
    ElementTree.SubElement(inertial, "inertia", inertia)
    joint = ElementTree.SubElement(root, "joint", {"name": f"{TOOL_LINK}_joint", "type": "fixed"})
    ElementTree.SubElement(joint, "parent", {"link": robot.tool_link})
    ElementTree.SubElement(joint, "child", {"link": TOOL_LINK})
    numbers = {
        "xyz": robot.tool_from_link[:3, 3].tolist(),
        "rpy": list(rpy_from_rotation(robot.tool_from_link[:3, :3])),
    }
    ElementTree.SubElement(
        joint, "origin", {key: " ".join(f"{v:.12g}" for v in value) for key, value in numbers.items()}
    )
