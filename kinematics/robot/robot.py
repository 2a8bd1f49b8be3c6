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

from kinematics.errors import UnusableRobot
from kinematics.geometry import urdf
from kinematics.geometry.transforms import Array, rotation_from_rpy, transform_from
from kinematics.geometry.urdf import Joint, Urdf

FOLDER = Path(__file__).parents[1] / "robots"
SHIPPED = tuple(sorted(path.stem for path in FOLDER.glob("*.toml")))

TOOL_LINK = "tool_of_kinematics"  # added if no link of the URDF is in the tool frame
RAMP = 0.2  # from rest to full speed, if no acceleration is given [s]
JERK_RAMP = 0.02  # from zero to full acceleration, if no jerk is given [s]

Region = tuple[tuple[float, float], tuple[float, float]]  # of x and of y, world frame [m]

_AXES = {"x": (1, 0, 0), "y": (0, 1, 0), "z": (0, 0, 1), "-x": (-1, 0, 0), "-y": (0, -1, 0), "-z": (0, 0, -1)}
_TABLES = {
    "": {"urdf", "arm", "home", "tool", "gripper", "limits", "workspace"},
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

    @property
    def dof(self) -> int:
        """Number of arm joints."""
        return len(self.arm_joints)

    @property
    def tool_frame(self) -> str:
        """The link whose frame is the tool's."""
        exists = np.allclose(self.tool_from_link, np.eye(4))
        return self.tool_link if exists else TOOL_LINK

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
        found = self.urdf.root.iterfind(f"link[@name='{link}']/contact/*")
        return frozenset(element.tag for element in found)

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
    path = shipped if shipped.is_file() else Path(name_or_path)
    if not path.is_file():
        listed = ", ".join(SHIPPED)
        raise UnusableRobot(f"'{name_or_path}' is neither an arm nor a file; the arms are {listed}")
    try:
        table = tomllib.loads(path.read_text())
    except tomllib.TOMLDecodeError as unexpected:
        raise UnusableRobot(f"{path} is not TOML: {unexpected}") from unexpected
    return _robot(path, table)


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


def _robot(path: Path, table: Mapping[str, Any]) -> Robot:
    _check_keys(path, table)
    description = urdf.read(urdf.resolved_path(table["urdf"], path.parent))
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
    )
    _check_fingers(path, made)
    return made


def _numbers(path: Path, key: str, value: Any) -> Array:
    """Return a list of finite numbers (n,)."""
    try:
        numbers = np.array(value, dtype=float)
    except (TypeError, ValueError):
        numbers = np.array(math.nan)
    if numbers.ndim != 1 or not np.isfinite(numbers).all():
        raise UnusableRobot(f"{path}: `{key}` needs a list of numbers, found {value}")
    return numbers


def _workspace(path: Path, value: Any) -> Region | None:
    if value is None:
        return None
    try:
        (x0, x1), (y0, y1) = value
        region = ((float(x0), float(x1)), (float(y0), float(y1)))
    except (TypeError, ValueError) as unexpected:
        raise UnusableRobot(
            f"{path}: workspace is [[x from, x to], [y from, y to]] in metres, found {value}"
        ) from unexpected
    if not (x0 < x1 and y0 < y1):
        raise UnusableRobot(f"{path}: workspace needs increasing limits, found {value}")
    return region


def _check_keys(path: Path, top: Mapping[str, Any]) -> None:
    for name in filter(None, _TABLES):
        if not isinstance(top.get(name, {}), dict):
            raise UnusableRobot(f"{path}: [{name}] must be a table, found {top[name]!r}")
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
            raise UnusableRobot(f"{path}: '{key}' needs a string, found {text!r}")
    for key, names in (("arm", top["arm"]), ("joints", top["gripper"]["joints"])):
        if not isinstance(names, list) or not all(isinstance(name, str) for name in names):
            raise UnusableRobot(f"{path}: '{key}' needs a list of joint names, found {names!r}")


def _check_chain(path: Path, description: Urdf, arm: tuple[str, ...], tool_link: str) -> None:
    """Raise `UnusableRobot` unless the arm's joints are those that lead to the tool, in order."""
    moving = tuple(joint.name for joint in description.chain_to(tool_link) if joint.type != "fixed")
    if moving != arm:
        raise UnusableRobot(
            f"{path}: from the base to '{tool_link}' the URDF has the joints {list(moving)}, "
            f"'arm' has {list(arm)}; it must name the same joints in the same order"
        )


def _check_fingers(path: Path, made: Robot) -> None:
    for joint in made.finger_joints:
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
        if axis not in _AXES:
            raise UnusableRobot(f"{path}: '{key}' must be one of {', '.join(_AXES)}, found {axis!r}")
    z, y = (np.array(_AXES[axis], float) for axis in axes.values())
    if abs(float(z @ y)) > 0.5:
        raise UnusableRobot(f"{path}: the gripper cannot close along its own approach")
    rotation = np.array([np.cross(y, z), y, z]).T
    rpy, xyz = (_numbers(path, key, table.get(key, (0, 0, 0))) for key in ("rpy", "xyz"))
    if rpy.shape != (3,) or xyz.shape != (3,):
        raise UnusableRobot(f"{path}: `xyz` and `rpy` of the tool need three numbers, found {xyz}, {rpy}")
    link = transform_from(rotation_from_rpy(rpy), xyz)
    return link @ transform_from(rotation, (0.0, 0.0, 0.0))
