"""From a URDF file to its joints and to one description that all libraries read the same way.

Mesh paths become absolute. Faults that a library would pass over silently are errors here.
"""

import copy
import importlib.util
import re
import xml.etree.ElementTree as ElementTree
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from kinematics.errors import UnusableRobot
from kinematics.geometry.transforms import Array, rotation_about, rotation_from_rpy, transform_from

Element = ElementTree.Element

_PLACED = ("inertial", "visual", "collision")  # children of a link that have an origin


@dataclass(frozen=True)
class Mimic:
    """A joint that follows another: its value is `multiplier` times the other's, plus `offset`."""

    joint: str
    multiplier: float
    offset: float


@dataclass(frozen=True)
class Joint:
    """One joint of the URDF; a missing limit is None."""

    name: str
    type: str
    parent: str
    child: str
    origin: Array  # (4, 4) of the joint to the parent link
    axis: Array  # (3,)
    lower: float | None  # the soft limit, if there is one [rad] or [m]
    upper: float | None
    velocity: float | None  # [rad/s] or [m/s]
    effort: float | None  # [N m] or [N]
    mimic: Mimic | None

    def motion(self, value: float) -> Array:
        """Return the transform of the child link to the parent link (4, 4) at a joint value."""
        if self.type == "prismatic":
            return self.origin @ transform_from(np.eye(3), self.axis * value)
        return self.origin @ transform_from(rotation_about(self.axis, value), (0.0, 0.0, 0.0))


@dataclass(frozen=True)
class Urdf:
    """A robot description with absolute paths."""

    path: Path
    root: Element
    joints: dict[str, Joint]

    @property
    def links(self) -> list[str]:
        return [link.get("name", "?") for link in self.root.findall("link")]

    @property
    def parent_joint(self) -> dict[str, Joint]:
        """The joint above each link."""
        return {joint.child: joint for joint in self.joints.values()}

    def subtree_of(self, link: str) -> tuple[str, ...]:
        """Return the link and all its descendants."""
        links = [link]
        for parent in links:
            children = [joint.child for joint in self.joints.values() if joint.parent == parent]
            links += [child for child in children if child not in links]
        return tuple(links)

    def chain_to(self, link: str) -> tuple[Joint, ...]:
        """Return all joints from the base to a link, fixed ones too."""
        found, above = [], self.parent_joint
        while link in above:
            found.append(above[link])
            link = found[-1].parent
        return tuple(reversed(found))

    def translated(self, by: tuple[float, float, float]) -> "Urdf":
        """Return the robot with everything moved relative to its root frame [m]."""
        (base,) = set(self.links) - set(self.parent_joint)
        root = copy.deepcopy(self.root)
        on_base = [e for e in root.findall("joint") if self.joints[e.get("name", "")].parent == base]
        of_base = (e for e in root.iterfind(f"link[@name='{base}']/*") if e.tag in _PLACED)
        for element in (*on_base, *of_base):
            origin = element.find("origin")
            if origin is None:
                origin = ElementTree.SubElement(element, "origin")
            xyz = _numbers(origin, "xyz", (0.0, 0.0, 0.0)) + by
            origin.set("xyz", " ".join(f"{number:.12g}" for number in xyz))
        moved = {joint.name: joint for joint in (_joint(element, self.path) for element in on_base)}
        return replace(self, root=root, joints=self.joints | moved)


def read(path: Path) -> Urdf:
    """Read a URDF file; raise `UnusableRobot` if it or a mesh is missing, or it is malformed."""
    if not path.is_file():
        raise UnusableRobot(f"there is no URDF at {path}")
    try:
        root = ElementTree.fromstring(_with_prefixes_declared(path.read_text(encoding="utf-8")))
    except (ElementTree.ParseError, UnicodeDecodeError) as unexpected:
        raise UnusableRobot(f"{path} is not XML: {unexpected}") from unexpected
    _drop_foreign(root, path)
    if root.tag != "robot":
        raise UnusableRobot(f"{path}: expected a <robot>, found <{root.tag}>; is it a URDF?")
    for link in root.findall("link"):
        for mesh in link.iter("mesh"):
            mesh.set("filename", str(_mesh(mesh.get("filename", ""), path, link.get("name", "?"))))
    joints = [_joint(element, path) for element in root.findall("joint")]
    description = Urdf(path, root, {joint.name: joint for joint in joints})
    _check_tree(description, joints)
    return description


def _check_tree(description: Urdf, joints: list[Joint]) -> None:
    """Raise `UnusableRobot` unless links and joints form one tree."""
    path, links = description.path, description.links
    for kind, names in (("link", links), ("joint", [joint.name for joint in joints])):
        if twice := sorted({name for name in names if names.count(name) > 1}):
            raise UnusableRobot(f"{path}: there are two {kind}s called '{twice[0]}'")
    for joint in joints:
        for link in (joint.parent, joint.child):
            if link not in links:
                raise UnusableRobot(f"{path}: joint '{joint.name}' refers to a missing link '{link}'")
    children = [joint.child for joint in joints]
    roots = [link for link in links if link not in children]
    if len(roots) != 1 or set(description.subtree_of(roots[0])) != set(links) or len(children) >= len(links):
        raise UnusableRobot(
            f"{path}: links and joints must form one tree with one root; "
            f"found {len(links)} links, {len(joints)} joints and the roots {roots}"
        )


def _with_prefixes_declared(text: str) -> str:
    """Declare the prefixes of other tools' tags and attributes, such as `drake:…`, which URDFs often omit."""
    used = set(re.findall(r"[<\s/]([A-Za-z_][\w-]*):[A-Za-z_]", text)) - {"xml", "xmlns"}
    needed = sorted(prefix for prefix in used if f"xmlns:{prefix}=" not in text)
    declared = "".join(f' xmlns:{prefix}="{prefix}"' for prefix in needed)
    return re.sub(r"<robot\b", f"<robot{declared}", text, count=1)


def _drop_foreign(root: Element, path: Path) -> None:
    """Remove tags and attributes of other tools; raise `UnusableRobot` for xacro's."""
    for parent in list(root.iter()):
        for child in [child for child in parent if str(child.tag).startswith("{")]:
            if "xacro" in child.tag:
                raise UnusableRobot(f"{path} is an unexpanded xacro; expand it with `xacro {path.name}`")
            parent.remove(child)
        for key in [key for key in parent.attrib if key.startswith("{")]:
            del parent.attrib[key]


def resolved_path(reference: str, folder: Path) -> Path:
    """Return the path of a reference relative to a folder, or `package://NAME/…` of an installed package."""
    if not reference.startswith("package://"):
        return (folder / reference).resolve()
    package, _, rest = reference.removeprefix("package://").partition("/")
    # Located without importing it, since some packages print on import.
    spec = importlib.util.find_spec(package)
    if spec is None or spec.origin is None:
        raise UnusableRobot(f"the Python package '{package}' of {reference} is not installed")
    return Path(spec.origin).parent / rest


def _mesh(filename: str, urdf: Path, link: str) -> Path:
    """Return the path of a mesh; `package://` is looked for beside the URDF and in every folder above it."""
    plain = filename.removeprefix("package://").removeprefix("file://")
    tried = [urdf.parent / plain]
    if filename.startswith("package://"):
        _, _, within = plain.partition("/")
        for folder in urdf.parents:
            tried += [folder / plain, folder / within]
    for place in tried:
        if place.is_file():
            return place.resolve()
    raise UnusableRobot(
        f"{urdf}: link '{link}' refers to a missing mesh {filename}; looked for {tried[0]}"
        + (" and in the folders above" if len(tried) > 1 else "")
    )


def _joint(element: Element, path: Path) -> Joint:
    name = element.get("name", "?")
    parent, child = element.find("parent"), element.find("child")
    if parent is None or child is None:
        raise UnusableRobot(f"{path}: joint '{name}' lacks a <parent> or a <child>")
    limit, soft, mimic = (element.find(tag) for tag in ("limit", "safety_controller", "mimic"))
    axis = _numbers(element.find("axis"), "xyz", (1.0, 0.0, 0.0))
    lower, upper = _number(limit, "lower"), _number(limit, "upper")
    if limit is not None and element.get("type") in ("revolute", "prismatic"):
        lower, upper = lower or 0.0, upper or 0.0  # the format's defaults
    return Joint(
        name,
        element.get("type", "?"),
        parent.get("link", "?"),
        child.get("link", "?"),
        origin_of(element),
        axis / max(float(np.linalg.norm(axis)), 1e-9),
        _first(_number(soft, "soft_lower_limit"), lower),
        _first(_number(soft, "soft_upper_limit"), upper),
        _number(limit, "velocity"),
        _number(limit, "effort"),
        None
        if mimic is None
        else Mimic(
            mimic.get("joint", "?"),
            _first(_number(mimic, "multiplier"), 1.0) or 1.0,
            _first(_number(mimic, "offset"), 0.0) or 0.0,
        ),
    )


def origin_of(element: Element) -> Array:
    """Return the transform of an element's `<origin>` (4, 4), by default the identity."""
    origin = element.find("origin")
    xyz, rpy = (_numbers(origin, key, (0.0, 0.0, 0.0)) for key in ("xyz", "rpy"))
    return transform_from(rotation_from_rpy(rpy), xyz)


def _numbers(element: Element | None, key: str, default: tuple[float, ...]) -> Array:
    text = None if element is None else element.get(key)
    return np.array(default if text is None else [float(word) for word in text.split()])


def _number(element: Element | None, key: str) -> float | None:
    text = None if element is None else element.get(key)
    return None if text is None else float(text)


def _first(value: float | None, otherwise: float | None) -> float | None:
    return otherwise if value is None else value
