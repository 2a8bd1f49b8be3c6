"""From the description of a robot to models for Pinocchio, MuJoCo (also for mink) and PyBullet."""

import copy
import math
import xml.etree.ElementTree as ElementTree
from collections.abc import Callable
from functools import cache, wraps
from pathlib import Path
from typing import Any, TypeVar

import mujoco
import pinocchio

from kinematics.errors import UnusableRobot, unforeseen_is_unusable
from kinematics.geometry import meshes
from kinematics.geometry.transforms import rpy_from_rotation
from kinematics.robot.robot import TOOL_LINK, Robot

Element = ElementTree.Element
Measured = TypeVar("Measured")

_MASS = 0.2  # of a link with a shape and without a mass in the URDF [kg]
_FRAME_MOMENT = 1e-6  # of a link without a shape [kg m2]
_COMPILER = {
    "strippath": "false",
    "discardvisual": "true",
    "fusestatic": "false",
    "balanceinertia": "true",  # moments that no body can have are in many a URDF
}
_MOMENTS = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")


def per_robot(measure: Callable[[Robot], Measured]) -> Callable[[Robot], Measured]:
    """Decorate a function of a robot: it runs once a robot, and fails by nothing but `UnusableRobot`."""

    @cache
    @wraps(measure)
    def measured(robot: Robot) -> Measured:
        with unforeseen_is_unusable(robot.urdf.path):
            return measure(robot)

    return measured


def tree(robot: Robot) -> Element:
    """Return the URDF in a form that all libraries read the same way.

    Paths are absolute, the tool frame is a link, continuous joints are limited to one turn, and joints that
    belong neither to the arm nor to the gripper are fixed.
    """
    root = copy.deepcopy(robot.urdf.root)
    moving = {*robot.arm_joints, *(joint.name for joint in robot.finger_joints)}
    for joint in root.findall("joint"):
        if joint.get("name") not in moving:
            joint.set("type", "fixed")
    _limit_continuous_joints(root, robot)
    for mesh in root.iterfind("link/collision/geometry/mesh"):
        mesh.set("filename", str(meshes.readable_mesh(Path(mesh.get("filename", "")))))
    if robot.tool_frame == TOOL_LINK:
        _add_tool(root, robot)
    return root


def text(root: Element) -> str:
    """Return an XML tree as text, in short lines: PyBullet breaks those of more than 8,191 bytes anywhere."""
    ElementTree.indent(root)
    return ElementTree.tostring(root, encoding="unicode")


def for_bullet(robot: Robot, visuals: bool) -> str:
    """Return the URDF for PyBullet; without visuals it loads six times faster.

    Every link gets a mass, since PyBullet gives a kilogram to links without one, mere frames included.
    """
    root = _with_masses(tree(robot))
    if not visuals:
        _drop(root, "visual")
    return text(root)


def for_dynamics(robot: Robot) -> Element:
    """Return arm and gripper with masses, for a simulator that couples fingers its own way.

    Friction of the joints is left out, as a real arm's controller makes up for it, and moments of links
    without shapes, which are mere frames and often have those of a link of metres.
    """
    root = _with_masses(tree(robot))
    _drop(root, "visual")
    for link in root.findall("link"):
        if link.find("collision") is None:
            mass = link.find("inertial/mass")
            _set_inertia(link, 0.0 if mass is None else float(mass.get("value", 0.0)), _FRAME_MOMENT)
    for joint in root.findall("joint"):
        for element in [*joint.findall("mimic"), *joint.findall("dynamics")]:
            joint.remove(element)
    return root


def _with_masses(root: Element) -> Element:
    """Give a mass to every link without one."""
    for link in root.findall("link"):
        if link.find("inertial/mass") is None or link.find("inertial/inertia") is None:
            mass = link.find("inertial/mass")
            default = _MASS if link.find("collision") is not None else 0.0
            _set_inertia(link, default if mass is None else float(mass.get("value", default)))
    return root


def for_kinematics(robot: Robot) -> Element:
    """Return the arm alone: fingers are fixed, since mimic joints would cost equalities in every update.

    All links have the same mass, since a URDF may say less of masses than a library requires.
    """
    root = tree(robot)
    _drop(root, "visual")
    for link in root.findall("link"):
        _set_inertia(link, _MASS)
    for joint in root.findall("joint"):
        for mimic in joint.findall("mimic"):
            joint.remove(mimic)
        if joint.get("name") not in robot.arm_joints:
            joint.set("type", "fixed")
    return root


@per_robot
def pinocchio_model(robot: Robot) -> Any:
    """Return the arm alone, within its soft limits."""
    try:
        model = pinocchio.buildModelFromXML(text(for_kinematics(robot)))
    except ValueError as unexpected:
        raise UnusableRobot(f"{robot.urdf.path}: Pinocchio cannot read it: {unexpected}") from unexpected
    found = tuple(name for name in model.names if name != "universe")
    if found != robot.arm_joints:
        raise UnusableRobot(f"{robot.urdf.path}: Pinocchio orders the joints {found}")
    model.lowerPositionLimit = robot.limits.lower.copy()
    model.upperPositionLimit = robot.limits.upper.copy()
    return model


@per_robot
def mujoco_model(robot: Robot) -> Any:
    """Return the arm alone, for mink."""
    return compiled(mujoco_spec(robot), robot)


def compiled(spec: Any, robot: Robot) -> Any:
    """Compile a MuJoCo description; raise `UnusableRobot` if it cannot be, as for a broken mesh."""
    try:
        return spec.compile()
    except ValueError as unexpected:
        raise UnusableRobot(f"{robot.urdf.path}: MuJoCo cannot read it: {unexpected}") from unexpected


def mujoco_spec(robot: Robot) -> Any:
    """Return the arm with fixed fingers as an editable MuJoCo description, within its soft limits."""
    return mujoco_spec_of(for_kinematics(robot), robot)


def mujoco_spec_of(root: Element, robot: Robot) -> Any:
    """Return one of this module's URDFs as an editable MuJoCo description, within the arm's soft limits.

    Meshes get names of our own, since MuJoCo takes two files of one name to be the same.
    """
    assets: dict[str, bytes] = {}
    for mesh in root.iter("mesh"):
        path = Path(mesh.get("filename", ""))
        name = f"mesh{len(assets)}{path.suffix.lower()}"
        assets[name] = path.read_bytes()
        mesh.set("filename", name)
    for link in root.findall("link"):
        for number, collision in enumerate(link.findall("collision")):
            collision.set("name", f"{link.get('name')}/{number}")
    options = ElementTree.Element("mujoco")
    ElementTree.SubElement(options, "compiler", _COMPILER)
    root.insert(0, options)
    try:
        spec = mujoco.MjSpec.from_string(text(root), assets=assets)
    except ValueError as unexpected:
        raise UnusableRobot(f"{robot.urdf.path}: MuJoCo cannot read it: {unexpected}") from unexpected
    for mesh in spec.meshes:  # only hulls matter, and the inside of a mesh may not be well-defined
        mesh.inertia = mujoco.mjtMeshInertia.mjMESH_INERTIA_CONVEX
    limits = robot.limits
    for name, lower, upper in zip(robot.arm_joints, limits.lower, limits.upper, strict=True):
        spec.joint(name).limited = mujoco.mjtLimited.mjLIMITED_TRUE
        spec.joint(name).range = [lower, upper]
    return spec


def _drop(root: Element, tag: str) -> None:
    for link in root.findall("link"):
        for element in link.findall(tag):
            link.remove(element)


def _limit_continuous_joints(root: Element, robot: Robot) -> None:
    """Make continuous joints revolute: in Pinocchio a continuous joint has two coordinates."""
    for joint in root.findall("joint"):
        if joint.get("type") == "continuous":
            joint.set("type", "revolute")
            limit = joint.find("limit")
            limit = ElementTree.SubElement(joint, "limit") if limit is None else limit
            lower, upper = _turn(joint.get("name", ""), robot)
            limit.set("lower", f"{lower:.12g}")
            limit.set("upper", f"{upper:.12g}")


def _turn(name: str, robot: Robot) -> tuple[float, float]:
    """Return the limits of a continuous joint of the arm, or of a finger [rad]."""
    if name not in robot.arm_joints:
        joint = robot.urdf.joints[name]
        return (
            -math.pi if joint.lower is None else joint.lower,
            math.pi if joint.upper is None else joint.upper,
        )
    index = robot.arm_joints.index(name)
    return float(robot.limits.lower[index]), float(robot.limits.upper[index])


def _set_inertia(link: Element, mass: float, moment: float = 0.1) -> None:
    for present in link.findall("inertial"):
        link.remove(present)
    inertial = ElementTree.SubElement(link, "inertial")
    ElementTree.SubElement(inertial, "mass", {"value": str(mass)})
    moments = {key: str(moment) if key[1] == key[2] else "0" for key in _MOMENTS}
    ElementTree.SubElement(inertial, "inertia", moments)


def _add_tool(root: Element, robot: Robot) -> None:
    link = ElementTree.SubElement(root, "link", {"name": TOOL_LINK})
    _set_inertia(link, 0.0)
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
