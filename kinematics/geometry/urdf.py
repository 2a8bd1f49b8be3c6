"""From a URDF file to its joints and to one description that all libraries read the same way.

Mesh paths become absolute. Faults that a library would pass over silently are errors here.
"""

import copy
import importlib.util
import xml.etree.ElementTree as ElementTree
from collections import Counter
from dataclasses import dataclass, replace
from importlib.machinery import PathFinder
from pathlib import Path

import numpy as np

from kinematics.errors import UnusableRobot, shown
from kinematics.geometry.bounded_files import Element, XmlTree, exists, read_xml
from kinematics.geometry.transforms import Array, rotation_about, rotation_from_rpy, transform_from
from kinematics.geometry.urdf_rules import check_rules

MOST_BYTES = 10_000_000

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
    def links_without_collision(self) -> list[str]:
        """The links that can be seen, and that no check of collisions would notice."""
        seen = (link for link in self.root.findall("link") if link.find("visual") is not None)
        return [link.get("name", "?") for link in seen if link.find("collision") is None]

    @property
    def parent_joint(self) -> dict[str, Joint]:
        """The joint above each link."""
        return {joint.child: joint for joint in self.joints.values()}

    def subtree_of(self, link: str) -> tuple[str, ...]:
        """Return the link and all its descendants."""
        below: dict[str, list[str]] = {}
        for joint in self.joints.values():
            below.setdefault(joint.parent, []).append(joint.child)
        links = {link: None}
        waiting = [link]
        for parent in waiting:
            children = [child for child in below.get(parent, []) if child not in links]
            links |= dict.fromkeys(children)
            waiting += children
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
        moved = {joint.name: joint for joint in (_joint(element) for element in on_base)}
        return replace(self, root=root, joints=self.joints | moved)


def read(path: Path, optional_visuals: bool = False) -> Urdf:
    """Read a URDF file; raise `UnusableRobot` if it or a mesh is missing, or it is malformed.

    Args:
        optional_visuals: leave out visuals whose meshes are in a package that is not installed.
    """
    if not exists(path):
        raise UnusableRobot(f"there is no URDF at {path}")
    tree = read_xml(path, MOST_BYTES)
    _drop_foreign(tree)
    check_rules(tree)
    root = tree.root
    _keep_what_counts(root)
    for link in root.findall("link"):
        if optional_visuals:
            _drop_absent_visuals(link)
        for mesh in link.iter("mesh"):
            mesh.set("filename", str(_mesh(mesh.get("filename", ""), path, link.get("name", "?"))))
    joints = [_joint(element) for element in root.findall("joint")]
    description = Urdf(path, root, {joint.name: joint for joint in joints})
    _check_tree(description, joints)
    return description


def _check_tree(description: Urdf, joints: list[Joint]) -> None:
    """Raise `UnusableRobot` unless links and joints form one tree."""
    path, links = description.path, description.links
    for kind, names in (("link", links), ("joint", [joint.name for joint in joints])):
        if twice := sorted(name for name, count in Counter(names).items() if count > 1):
            raise UnusableRobot(f"{path}: there are two {kind}s called '{twice[0]}'")
    known = set(links)
    for joint in joints:
        for link in (joint.parent, joint.child):
            if link not in known:
                raise UnusableRobot(f"{path}: joint '{joint.name}' refers to a missing link '{link}'")
    children = {joint.child for joint in joints}
    roots = [link for link in links if link not in children]
    if len(roots) != 1 or set(description.subtree_of(roots[0])) != known or len(joints) >= len(links):
        raise UnusableRobot(
            f"{path}: links and joints must form one tree with one root; "
            f"found {len(links)} links, {len(joints)} joints and the roots {shown(roots)}"
        )


def _drop_foreign(tree: XmlTree) -> None:
    """Remove tags and attributes of other tools; raise `UnusableRobot` for xacro's."""
    for parent in list(tree.root.iter()):
        for child in [child for child in parent if ":" in child.tag]:
            if child.tag.startswith("xacro:"):
                raise UnusableRobot(
                    f"{tree.place_of(child)}: this is an unexpanded xacro; expand it with "
                    f"`xacro {tree.path.name}`"
                )
            parent.remove(child)
        for key in [key for key in parent.attrib if ":" in key or key == "xmlns"]:
            del parent.attrib[key]


def _keep_what_counts(root: Element) -> None:
    """Remove all but links and joints; give each visual its colour, which another may have declared."""
    colours: dict[str, Element] = {}
    for material in root.iter("material"):
        colour = material.find("color")
        if colour is not None and colour.get("rgba"):
            colours.setdefault(material.get("name", ""), colour)
    for other in [child for child in root if child.tag not in ("link", "joint")]:
        root.remove(other)
    for part in (*root.iterfind("link/visual"), *root.iterfind("link/collision")):
        for material in part.findall("material"):
            part.remove(material)
            own = material.find("color")
            colour = colours.get(material.get("name", "")) if own is None else own
            if part.tag == "visual" and colour is not None:
                _set_colour(part, colour.get("rgba", "").split())


def _set_colour(visual: Element, rgba: list[str]) -> None:
    """Give a visual a colour of its own; an opacity that is not given is 1."""
    if rgba:
        name = "_".join(rgba)  # readers share materials by name
        material = ElementTree.SubElement(visual, "material", {"name": name})
        ElementTree.SubElement(material, "color", {"rgba": " ".join([*rgba, "1"][:4])})


def resolved_path(reference: str, folder: Path) -> Path:
    """Return the path of a reference relative to a folder, or `package://NAME/…` of an installed package."""
    if not reference.startswith("package://"):
        try:
            return (folder / reference).resolve()
        except (OSError, ValueError, RuntimeError):  # a path that no system accepts, or a loop of links
            return folder / reference
    package, _, rest = reference.removeprefix("package://").partition("/")
    found = _installed(package)
    if found is None:
        raise UnusableRobot(f"the Python package '{package}' of {reference} is not installed")
    return found / rest


def _mesh(filename: str, urdf: Path, link: str) -> Path:
    """Return a mesh's path; a package is looked for beside the URDF, in the folders above, and in Python."""
    plain = filename.removeprefix("package://").removeprefix("file://")
    tried = [urdf.parent / plain]
    if filename.startswith("package://"):
        _, _, within = plain.partition("/")
        for folder in urdf.parents:
            tried += [folder / plain, folder / within]
        tried += [found / within for found in [_installed(plain.partition("/")[0])] if found is not None]
    for place in tried:
        if exists(place):
            return place.resolve()
    raise UnusableRobot(
        f"{urdf}: link '{link}' refers to a missing mesh {filename}; looked for {tried[0]}"
        + (" and in the folders above" if len(tried) > 1 else "")
    )


def _drop_absent_visuals(link: Element) -> None:
    """Remove the visuals whose meshes are in a package that is not installed."""
    for visual in link.findall("visual"):
        for mesh in visual.iter("mesh"):
            filename = mesh.get("filename", "")
            if filename.startswith("package://"):
                if PathFinder.find_spec(filename.removeprefix("package://").partition("/")[0]) is None:
                    link.remove(visual)


def _installed(package: str) -> Path | None:
    """Return the folder of an installed Python package, located without importing it: some print then."""
    try:
        spec = importlib.util.find_spec(package) if package.isidentifier() else None
    except ValueError:  # of a module without a file
        spec = None
    return None if spec is None or spec.origin is None else Path(spec.origin).parent


def _joint(element: Element) -> Joint:
    parent, child = element.find("parent"), element.find("child")
    assert parent is not None and child is not None  # by the rules
    limit, soft, mimic = (element.find(tag) for tag in ("limit", "safety_controller", "mimic"))
    axis = _numbers(element.find("axis"), "xyz", (1.0, 0.0, 0.0))
    lower, upper = _number(limit, "lower"), _number(limit, "upper")
    if limit is not None and element.get("type") in ("revolute", "prismatic"):
        lower, upper = lower or 0.0, upper or 0.0  # the format's defaults
    return Joint(
        element.get("name", "?"),
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
