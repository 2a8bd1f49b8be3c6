"""From a URDF and a short TOML to the checked description of an arm.

Lengths in metres, angles in radians, the robot's base at the world's origin. The tool frame is between the
fingertips: z along the approach, y along the closing direction.
"""

import math
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cache, cached_property
from pathlib import Path
from typing import Any

import numpy as np

from kinematics.errors import UnusableRobot, shown, unforeseen_is_unusable
from kinematics.geometry import urdf
from kinematics.geometry.bounded_files import exists, read_text
from kinematics.geometry.transforms import Array, rotation_from_rpy, transform_from
from kinematics.geometry.urdf import Joint, Urdf

FOLDER = Path(__file__).parents[1] / "robots"
SHIPPED = tuple(sorted(path.stem for path in FOLDER.glob("*.toml")))

TOOL_LINK = "tool_of_kinematics"  # added if no link of the URDF is in the tool frame
MOST_BYTES = 20_000  # of a TOML, whose parser needs the square of its length for some texts
LARGEST = 1e9  # number in a TOML, in its unit
RAMP = 0.2  # from rest to full speed, if no acceleration is given [s]
JERK_RAMP = 0.02  # from zero to full acceleration, if no jerk is given [s]

Region = tuple[tuple[float, float], tuple[float, float]]  # of x and of y, world frame [m]

_AXES = {"x": (1, 0, 0), "y": (0, 1, 0), "z": (0, 0, 1), "-x": (-1, 0, 0), "-y": (0, -1, 0), "-z": (0, 0, -1)}
_TABLES = {
    "": {
        "urdf",
        "arm",
        "home",
        "tool",
        "gripper",
        "limits",
        "workspace",
        "allowed_collisions",
        "without_collision",
    },
    "tool": {"link", "xyz", "rpy", "approach", "closing"},
    "gripper": {"joints"},
    "limits": {"lower", "upper", "velocity", "effort", "acceleration", "jerk"},
}


@dataclass(frozen=True)
class Limits:
    """Soft limits of the arm's joints, each (dof,)."""

    lower: Array  # [rad]
    upper: Array  # [rad]
    velocity: Array  # [rad/s]
    effort: Array  # [N m]
    acceleration: Array  # [rad/s2]
    jerk: Array  # [rad/s3]

    def contains(self, q: Array, tolerance: float = 1e-9) -> bool:
        """Return whether joint positions are within the limits."""
        return bool((q >= self.lower - tolerance).all() and (q <= self.upper + tolerance).all())


@dataclass(frozen=True, eq=False)
class Robot:
    """An arm whose URDF and TOML were checked."""

    name: str
    urdf: Urdf
    arm_joints: tuple[str, ...]
    gripper_joints: tuple[str, ...]  # the driven ones, without their mimics
    home: Array  # (dof,) [rad]
    limits: Limits
    tool_link: str
    tool_from_link: Array  # (4, 4) of the tool frame to that link
    workspace: Region | None  # of the TOML; without it `workspace_of` measures one [m]
    allowed_collisions: tuple[tuple[str, str], ...] = ()  # pairs of links that are never checked

    @property
    def dof(self) -> int:
        """Number of arm joints."""
        return len(self.arm_joints)

    @property
    def tool_frame(self) -> str:
        """The link whose frame is the tool's."""
        exists = np.allclose(self.tool_from_link, np.eye(4))
        is_unique = self.tool_link not in self.urdf.joints  # to Pinocchio joints are frames, too
        return self.tool_link if exists and is_unique else TOOL_LINK

    @cached_property
    def chain(self) -> tuple[Joint, ...]:
        """All joints from the base to the tool link, fixed ones too."""
        return self.urdf.chain_to(self.tool_link)

    @property
    def flange(self) -> str:
        """The link that the last arm joint moves."""
        return self.urdf.joints[self.arm_joints[-1]].child

    @cached_property
    def tool_to_flange(self) -> Array:
        """Transform of the tool frame to the flange (4, 4)."""
        transform = np.eye(4)
        for joint in self.chain[[j.name for j in self.chain].index(self.arm_joints[-1]) + 1 :]:
            transform = transform @ joint.origin
        return transform @ self.tool_from_link

    @cached_property
    def hand_links(self) -> tuple[str, ...]:
        """The flange and all links below it, fingers included."""
        return self.urdf.subtree_of(self.flange)

    @cached_property
    def finger_links(self) -> tuple[str, ...]:
        """The links that finger joints move, with pads and tips fixed to them."""
        found = (link for joint in self.finger_joints for link in self.urdf.subtree_of(joint.child))
        return tuple(dict.fromkeys(found))

    def contact_of(self, link: str) -> frozenset[str]:
        """Return the contact properties that the URDF gives for a link, such as `lateral_friction`."""
        (element,) = (each for each in self.urdf.root.findall("link") if each.get("name") == link)
        return frozenset(child.tag for child in element.iterfind("contact/*"))

    @cached_property
    def finger_joints(self) -> tuple[Joint, ...]:
        """Driven gripper joints, then those that mimic them."""
        joints = self.urdf.joints
        found = [joints[name] for name in self.gripper_joints]
        for leader in found:  # a mimic may have mimics of its own
            followers = (j for j in joints.values() if j.mimic and j.mimic.joint == leader.name)
            found += [joint for joint in followers if joint not in found]
        return tuple(found)

    def finger_values(self, driven: Array) -> dict[str, float]:
        """Return the values of all finger joints, given those of the driven ones."""
        values = dict(zip(self.gripper_joints, driven.tolist(), strict=True))
        for joint in self.finger_joints[len(driven) :]:
            assert joint.mimic is not None
            values[joint.name] = joint.mimic.multiplier * values[joint.mimic.joint] + joint.mimic.offset
        return values


@cache
def load(name_or_path: str) -> Robot:
    """Load one of `SHIPPED` by its name, or a TOML by its path."""
    shipped = FOLDER / f"{name_or_path}.toml"
    path = shipped if exists(shipped) else Path(name_or_path)
    if not exists(path):
        listed = ", ".join(SHIPPED)
        raise UnusableRobot(f"'{name_or_path}' is neither an arm nor a file; the arms are {listed}")
    with unforeseen_is_unusable(path):
        return _robot(path, _table(path))


def panda() -> Robot:
    """Return the default arm."""
    return load("panda")


@cache
def with_base_at(robot: Robot, x: float, y: float) -> Robot:
    """Return the same arm with its base elsewhere on the table [m]."""
    if math.hypot(x, y) < 1e-9:
        return robot
    region = robot.workspace
    if region is not None:
        (x0, x1), (y0, y1) = region
        region = ((x0 + x, x1 + x), (y0 + y, y1 + y))
    return replace(robot, urdf=robot.urdf.translated((x, y, 0.0)), workspace=region)


def _table(path: Path) -> dict[str, Any]:
    text = read_text(path, MOST_BYTES)
    try:
        return tomllib.loads(text)
    except RecursionError as unexpected:
        raise UnusableRobot(f"{path}: its lists or tables are nested too deeply") from unexpected
    except ValueError as unexpected:  # beside its own error, of numbers with too many digits
        raise UnusableRobot(f"{path} is not TOML: {unexpected}") from unexpected


def _robot(path: Path, table: Mapping[str, Any]) -> Robot:
    _check_keys(path, table)
    description = urdf.read(urdf.resolved_path(table["urdf"], path.parent), path.parent == FOLDER)
    arm, gripper = tuple(table["arm"]), tuple(table["gripper"]["joints"])
    for name in (*arm, *gripper):
        if name not in description.joints:
            listed = ", ".join(j.name for j in description.joints.values() if j.type != "fixed")
            raise UnusableRobot(f"{path}: no joint of the URDF is called '{name}'; there are {listed}")
    link = table["tool"]["link"]
    if link not in description.links:
        raise UnusableRobot(
            f"{path}: no link of the URDF is called '{link}'; there are {', '.join(description.links)}"
        )
    _check_chain(path, description, arm, link)
    limits = _limits(path, [description.joints[name] for name in arm], table.get("limits", {}))
    home = _numbers(path, "home", table["home"])
    if home.shape != (len(arm),) or not limits.contains(home):
        raise UnusableRobot(f"{path}: home needs {len(arm)} joint positions within the limits, found {home}")
    _check_collision_geometry(path, description, table.get("without_collision", []))
    made = Robot(
        path.stem,
        description,
        arm,
        gripper,
        home,
        limits,
        link,
        _tool(path, table["tool"]),
        _workspace(path, table.get("workspace")),
        _allowed_collisions(path, description, table.get("allowed_collisions", [])),
    )
    _check_fingers(path, made)
    return made


def _numbers(path: Path, key: str, value: Any) -> Array:
    """Return a list of finite numbers (n,)."""
    if not isinstance(value, list | tuple) or not all(map(_is_number, value)):
        raise UnusableRobot(f"{path}: `{key}` needs a list of numbers, found {shown(value)}")
    return np.array(value, dtype=float)


def _is_number(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and abs(value) <= LARGEST


def _workspace(path: Path, value: Any) -> Region | None:
    if value is None:
        return None
    try:
        (x0, x1), (y0, y1) = (_numbers(path, "workspace", row).tolist() for row in value)
    except (TypeError, ValueError) as unexpected:
        raise UnusableRobot(
            f"{path}: workspace is [[x from, x to], [y from, y to]] in metres, found {shown(value)}"
        ) from unexpected
    if not (x0 < x1 and y0 < y1):
        raise UnusableRobot(f"{path}: workspace needs increasing limits, found {shown(value)}")
    return (x0, x1), (y0, y1)


def _check_collision_geometry(path: Path, description: Urdf, excepted: Any) -> None:
    """Raise `UnusableRobot` for links that plans would lead through anything."""
    _check_links(path, "without_collision", description, excepted)
    if missing := [link for link in description.links_without_collision if link not in excepted]:
        raise UnusableRobot(
            f"{description.path}: these links have a <visual> and no <collision>, so plans would lead them "
            f"through everything: {', '.join(missing)}; give them one, or list those that can meet nothing "
            f"under `without_collision` in {path.name}"
        )


def _allowed_collisions(path: Path, description: Urdf, value: Any) -> tuple[tuple[str, str], ...]:
    """Return the pairs of links whose collisions the TOML allows."""
    if not isinstance(value, list) or not all(isinstance(pair, list) and len(pair) == 2 for pair in value):
        raise UnusableRobot(
            f'{path}: `allowed_collisions` needs a list of pairs such as [["link_3", "link_5"]], '
            f"found {shown(value)}"
        )
    for pair in value:
        _check_links(path, "allowed_collisions", description, pair)
    return tuple((first, second) for first, second in value)


def _check_links(path: Path, key: str, description: Urdf, names: Any) -> None:
    """Raise `UnusableRobot` unless these are names of the URDF's links."""
    if not isinstance(names, list) or not all(isinstance(name, str) for name in names):
        raise UnusableRobot(f"{path}: `{key}` needs names of links, found {shown(names)}")
    links = description.links
    if unknown := [name for name in names if name not in links]:
        raise UnusableRobot(
            f"{path}: `{key}`: no link of the URDF is called '{unknown[0]}'; there are {', '.join(links)}"
        )


def _check_keys(path: Path, top: Mapping[str, Any]) -> None:
    for name in filter(None, _TABLES):
        if not isinstance(top.get(name, {}), dict):
            raise UnusableRobot(f"{path}: [{name}] must be a table, found {shown(top[name])}")
    for name, allowed in _TABLES.items():
        table = top if not name else top.get(name, {})
        if unknown := sorted(set(table) - allowed):
            where = f"[{name}]" if name else "the top level"
            raise UnusableRobot(f"{path}: {where} has no key '{unknown[0]}'; it takes {sorted(allowed)}")
    needed = [("", key) for key in ("urdf", "arm", "home", "tool", "gripper")]
    for name, key in [*needed, ("tool", "link"), ("gripper", "joints")]:
        if key not in (top[name] if name else top):
            raise UnusableRobot(f"{path}: '{key}' is missing{f' from [{name}]' if name else ''}")
    for key, text in (("urdf", top["urdf"]), ("link", top["tool"]["link"])):
        if not isinstance(text, str):
            raise UnusableRobot(f"{path}: '{key}' needs a string, found {shown(text)}")
    for key, names in (("arm", top["arm"]), ("joints", top["gripper"]["joints"])):
        if not isinstance(names, list) or not all(isinstance(name, str) for name in names):
            raise UnusableRobot(f"{path}: '{key}' needs a list of joint names, found {shown(names)}")
        if not names or len(set(names)) < len(names):
            raise UnusableRobot(
                f"{path}: '{key}' must name one joint or more, each once, found {shown(names)}"
            )


def _check_chain(path: Path, description: Urdf, arm: tuple[str, ...], tool_link: str) -> None:
    """Raise `UnusableRobot` unless the arm's joints are those that lead to the tool, in order."""
    moving = tuple(joint.name for joint in description.chain_to(tool_link) if joint.type != "fixed")
    if moving != arm:
        raise UnusableRobot(
            f"{path}: from the base to '{tool_link}' the URDF has the joints {list(moving)}, "
            f"'arm' has {list(arm)}; it must name the same joints in the same order"
        )
    for name in arm:
        if description.joints[name].type not in ("revolute", "continuous", "prismatic"):
            kind = description.joints[name].type
            raise UnusableRobot(f"{path}: joint '{name}' is {kind}; an arm has revolute or sliding joints")


def _check_fingers(path: Path, made: Robot) -> None:
    for joint in made.finger_joints:
        if joint.type not in ("revolute", "continuous", "prismatic"):
            raise UnusableRobot(
                f"{path}: the gripper joint '{joint.name}' is {joint.type}, so it does not move"
            )
        if joint.name in made.arm_joints:
            raise UnusableRobot(f"{path}: '{joint.name}' is a joint of the arm and of the gripper")
        if joint.child not in made.hand_links:
            raise UnusableRobot(f"{path}: the gripper joint '{joint.name}' is not below the arm's last link")
        if joint.mimic is None and (joint.lower is None or joint.upper is None or joint.lower >= joint.upper):
            raise UnusableRobot(f"{made.urdf.path}: the gripper joint '{joint.name}' has no limits")


def _limits(path: Path, joints: list[Joint], table: Mapping[str, Any]) -> Limits:
    """Return the limits of the TOML, else of the URDF; accelerations and jerks are rarely in a URDF."""

    def of(key: str, default: list[float | None]) -> Array:
        values: list[float | None] = default
        if key in table:
            values = list(_numbers(path, key, table[key]).tolist())
        for joint, value in zip(joints, values, strict=False):
            if value is None or not math.isfinite(value) or (key in POSITIVE and value <= 0):
                raise UnusableRobot(
                    f"{path}: joint '{joint.name}' has no {key} limit in the URDF (found {value}); "
                    f"give `{key}`, one number per joint, under [limits]"
                )
        if len(values) != len(joints):
            raise UnusableRobot(f"{path}: `{key}` needs {len(joints)} numbers, found {len(values)}")
        return np.array(values)

    lower = of("lower", [-math.pi if j.type == "continuous" else j.lower for j in joints])
    upper = of("upper", [math.pi if j.type == "continuous" else j.upper for j in joints])
    for joint, low, high in zip(joints, lower, upper, strict=True):
        if low >= high:
            raise UnusableRobot(
                f"{path}: joint '{joint.name}' has no position limits (lower {low}, upper {high}); "
                "give `lower` and `upper`, one number per joint, under [limits]"
            )
    velocity = of("velocity", [joint.velocity for joint in joints])
    acceleration = of("acceleration", (velocity / RAMP).tolist())
    return Limits(
        lower,
        upper,
        velocity,
        of("effort", [joint.effort for joint in joints]),
        acceleration,
        of("jerk", (acceleration / JERK_RAMP).tolist()),
    )


POSITIVE = frozenset(("velocity", "effort", "acceleration", "jerk"))


def _tool(path: Path, table: Mapping[str, Any]) -> Array:
    """Return the transform of the tool frame to its link (4, 4), z along the approach and y along closing."""
    axes = {key: table.get(key, default) for key, default in (("approach", "z"), ("closing", "y"))}
    for key, axis in axes.items():
        if not isinstance(axis, str) or axis not in _AXES:
            raise UnusableRobot(f"{path}: '{key}' must be one of {', '.join(_AXES)}, found {shown(axis)}")
    z, y = (np.array(_AXES[axis], float) for axis in axes.values())
    if abs(float(z @ y)) > 0.5:
        raise UnusableRobot(f"{path}: the gripper cannot close along its own approach")
    rotation = np.array([np.cross(y, z), y, z]).T
    rpy, xyz = (_numbers(path, key, table.get(key, (0, 0, 0))) for key in ("rpy", "xyz"))
    if rpy.shape != (3,) or xyz.shape != (3,):
        raise UnusableRobot(f"{path}: `xyz` and `rpy` of the tool need three numbers, found {xyz}, {rpy}")
    link = transform_from(rotation_from_rpy(rpy), xyz)
    return link @ transform_from(rotation, (0.0, 0.0, 0.0))
