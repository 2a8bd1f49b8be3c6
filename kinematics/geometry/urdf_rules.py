"""What a URDF must have and may have: names, types, shapes and numbers. A fault names file, line and element.

The libraries that read a URDF disagree on what is malformed, and some pass over it silently.
"""

import math
from dataclasses import dataclass

from kinematics.errors import UnusableRobot, shown
from kinematics.geometry.bounded_files import Element, XmlTree

MOST_LINKS = 500
MOST_CHARACTERS = 1_000  # of an attribute, since PyBullet breaks lines of 8,191
LONGEST = 1e3  # size, position or scale [m]
JOINT_TYPES = ("revolute", "continuous", "prismatic", "fixed", "floating", "planar")
SHAPES = ("box", "cylinder", "sphere", "capsule", "mesh")


@dataclass(frozen=True)
class Numbers:
    """What an attribute takes."""

    counts: tuple[int, ...] = (1,)
    lowest: float = -math.inf
    highest: float = math.inf
    needed: bool = False


_ANY = Numbers()
_LENGTHS = Numbers((3,), -LONGEST, LONGEST)
_SIZE = Numbers(lowest=0.0, highest=LONGEST, needed=True)
_COLOUR = Numbers((3, 4))
_MOMENT = Numbers(needed=True)
_ATTRIBUTES: dict[tuple[str, str], Numbers] = {
    ("origin", "xyz"): _LENGTHS,
    ("origin", "rpy"): _LENGTHS,
    ("axis", "xyz"): _LENGTHS,
    ("box", "size"): Numbers((3,), 0.0, LONGEST, needed=True),
    ("cylinder", "radius"): _SIZE,
    ("cylinder", "length"): _SIZE,
    ("capsule", "radius"): _SIZE,
    ("capsule", "length"): _SIZE,
    ("sphere", "radius"): _SIZE,
    ("mesh", "scale"): _LENGTHS,
    ("color", "rgba"): _COLOUR,
    ("mass", "value"): Numbers(lowest=0.0, needed=True),
    **{("inertia", moment): _MOMENT for moment in ("ixx", "iyy", "izz")},
    **{("inertia", moment): _ANY for moment in ("ixy", "ixz", "iyz")},
    **{("limit", key): _ANY for key in ("lower", "upper", "velocity", "effort")},
    **{("safety_controller", f"soft_{end}_limit"): _ANY for end in ("lower", "upper")},
    **{("mimic", key): _ANY for key in ("multiplier", "offset")},
}
_CONTACT = "contact"  # all its children have one number, `value`


def check_rules(tree: XmlTree) -> None:
    """Raise `UnusableRobot` for a link or joint that breaks a rule."""
    root = tree.root
    if root.tag != "robot":
        raise UnusableRobot(f"{tree.path}: expected a <robot>, found <{root.tag}>; is it a URDF?")
    links, joints = root.findall("link"), root.findall("joint")
    if len(links) > MOST_LINKS:
        raise UnusableRobot(f"{tree.path}: it has {len(links)} links; at most {MOST_LINKS} are read")
    for element in (*links, *joints):
        if not (element.get("name") or "").strip():
            raise UnusableRobot(f"{tree.place_of(element)}: this {element.tag} has no name")
    for element in (*links, *joints, *root.findall("material")):
        where = f"{element.tag} '{element.get('name')}'"
        for part in element.iter():
            if any(len(text) > MOST_CHARACTERS for text in part.attrib.values()):
                raise UnusableRobot(
                    f"{tree.place_of(part)}: <{part.tag}> of {shown(where)} has an attribute of more than "
                    f"{MOST_CHARACTERS:,} characters"
                )
            _check_numbers(tree, part, where)
    for link in links:
        _check_shapes(tree, link)
    for joint in joints:
        _check_joint(tree, joint)


def _check_numbers(tree: XmlTree, element: Element, where: str) -> None:
    rules = [(key, rule) for (tag, key), rule in _ATTRIBUTES.items() if tag == element.tag]
    if element.tag == _CONTACT:
        for child in element:
            _check_number(tree, child, where, "value", _ANY)
    for key, rule in rules:
        _check_number(tree, element, where, key, rule)


def _check_number(tree: XmlTree, element: Element, where: str, key: str, rule: Numbers) -> None:
    text = element.get(key)
    if text is None:
        if rule.needed:
            raise UnusableRobot(f"{tree.place_of(element)}: <{element.tag}> of {where} lacks '{key}'")
        return
    try:
        numbers = [float(word) for word in text.split()]
    except ValueError:
        numbers = [math.nan]
    if len(numbers) in rule.counts and all(map(math.isfinite, numbers)):
        if all(rule.lowest <= number <= rule.highest for number in numbers):
            return
        wanted = f"from {rule.lowest:g} to {rule.highest:g}"
    else:
        wanted = "a number" if rule.counts == (1,) else f"{' or '.join(map(str, rule.counts))} numbers"
    hint = "; expand it with xacro" if "${" in text else ""
    raise UnusableRobot(
        f"{tree.place_of(element)}: '{key}' of <{element.tag}> of {where} must be {wanted}, "
        f"found {shown(text)}{hint}"
    )


def _check_shapes(tree: XmlTree, link: Element) -> None:
    """Raise `UnusableRobot` unless every visual and collision has one shape that all libraries read."""
    for part in (*link.findall("visual"), *link.findall("collision")):
        shapes = part.findall("geometry/*")
        if len(shapes) != 1 or shapes[0].tag not in SHAPES:
            found = ", ".join(f"<{shape.tag}>" for shape in shapes) or "none"
            raise UnusableRobot(
                f"{tree.place_of(part)}: <{part.tag}> of link '{link.get('name')}' must have one shape of "
                f"{', '.join(SHAPES)} in its <geometry>, found {found}"
            )


def _check_joint(tree: XmlTree, joint: Element) -> None:
    name, kind = joint.get("name"), joint.get("type")
    if kind not in JOINT_TYPES:
        raise UnusableRobot(
            f"{tree.place_of(joint)}: joint '{name}' has the type '{kind}', not one of "
            f"{', '.join(JOINT_TYPES)}"
        )
    for tag in ("parent", "child"):
        found = joint.find(tag)
        if found is None or found.get("link") is None:
            raise UnusableRobot(f"{tree.place_of(joint)}: joint '{name}' lacks a <parent> or a <child> link")
    axis = None if kind == "fixed" else joint.find("axis")
    if axis is not None and not any(float(word) for word in axis.get("xyz", "1 0 0").split()):
        raise UnusableRobot(f"{tree.place_of(axis)}: the <axis> of joint '{name}' has no direction")
