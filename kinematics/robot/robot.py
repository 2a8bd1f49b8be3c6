"""An arm: a URDF and a short TOML in, one description out, as Pinocchio, MuJoCo and PyBullet read it.

Lengths in metres, angles in radians, the robot's base at the world's origin. The tool frame sits
between the fingertips: z along the approach, y along the closing direction.
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

TOOL_LINK = "tool_of_kinematics"  # added where the URDF has no link in the tool's frame
RAMP = 0.2  # from rest to full speed, where no acceleration is given [s]
JERK_RAMP = 0.02  # from none to full acceleration, where no jerk is given [s]

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
    """Soft limits of the arm's joints, each an array of one number a joint."""

    lower: Array  # [rad]
    upper: Array  # [rad]
    velocity: Array  # [rad/s]
    effort: Array  # [N m]
    acceleration: Array  # [rad/s2]
    jerk: Array  # [rad/s3]

    def contains(self, q: Array, tolerance: float = 1e-9) -> bool:
        return bool((q >= self.lower - tolerance).all() and (q <= self.upper + tolerance).all())


@dataclass(frozen=True, eq=False)
class Robot:
    """A checked arm: holding one is the proof that its URDF and its TOML were sound."""

    name: str
    urdf: Urdf
    arm_joints: tuple[str, ...]
    gripper_joints: tuple[str, ...]  # those that are driven; their mimics follow
    home: Array  # (n,) [rad]
    limits: Limits
    tool_link: str
    tool_from_link: Array  # (4, 4) of our tool frame to that link
    workspace: Region | None  # where things lie, if the TOML tells; else `workspace_of` measures it [m]

    @property
    def dof(self) -> int:
        return len(self.arm_joints)

    @property
    def tool_frame(self) -> str:
        """The link whose frame is the tool's."""
        is_there = np.allclose(self.tool_from_link, np.eye(4))
        return self.tool_link if is_there else TOOL_LINK

    @cached_property
    def chain(self) -> tuple[Joint, ...]:
        """All joints from the base to the tool link, fixed ones too."""
        return self.urdf.chain_to(self.tool_link)

    @property
    def flange(self) -> str:
        """The link that the last arm joint turns."""
        return self.urdf.joints[self.arm_joints[-1]].child

    @cached_property
    def tool_to_flange(self) -> Array:
        """(4, 4)"""
        transform = np.eye(4)
        for joint in self.chain[[j.name for j in self.chain].index(self.arm_joints[-1]) + 1 :]:
            transform = transform @ joint.origin
        return transform @ self.tool_from_link

    @cached_property
    def hand_links(self) -> tuple[str, ...]:
        """The links that move with the last arm joint, and all fingers."""
        return self.urdf.carried_by(self.flange)

    @cached_property
    def finger_links(self) -> tuple[str, ...]:
        """The links that finger joints move, with the pads and tips that are fixed to them."""
        found = (link for joint in self.finger_joints for link in self.urdf.carried_by(joint.child))
        return tuple(dict.fromkeys(found))

    def contact_of(self, link: str) -> frozenset[str]:
        """What the URDF says of how a link touches: `lateral_friction`, `stiffness` …"""
        return frozenset(told.tag for told in self.urdf.root.iterfind(f"link[@name='{link}']/contact/*"))

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
        """Of every finger joint, by the values of the driven ones."""
        values = dict(zip(self.gripper_joints, driven.tolist(), strict=True))
        for joint in self.finger_joints[len(driven) :]:
            assert joint.mimic is not None
            values[joint.name] = joint.mimic.multiplier * values[joint.mimic.joint] + joint.mimic.offset
        return values


@cache
def load(name_or_path: str) -> Robot:
    """One of `SHIPPED` by its name, or a TOML of your own by its path."""
    shipped = FOLDER / f"{name_or_path}.toml"
    path = shipped if shipped.is_file() else Path(name_or_path)
    if not path.is_file():
        listed = ", ".join(SHIPPED)
        raise UnusableRobot(f"no arm is called '{name_or_path}' and no file either; there are {listed}")
    try:
        told = tomllib.loads(path.read_text())
    except tomllib.TOMLDecodeError as unexpected:
        raise UnusableRobot(f"{path} is no TOML: {unexpected}") from unexpected
    return _robot(path, told)


def panda() -> Robot:
    """The default arm."""
    return load("panda")


@cache
def standing(robot: Robot, x: float, y: float) -> Robot:
    """The same arm, its base at another place of the table [m]."""
    if math.hypot(x, y) < 1e-9:
        return robot
    region = robot.workspace
    if region is not None:
        (x0, x1), (y0, y1) = region
        region = ((x0 + x, x1 + x), (y0 + y, y1 + y))
    return replace(robot, urdf=robot.urdf.moved((x, y, 0.0)), workspace=region)


def _robot(path: Path, told: Mapping[str, Any]) -> Robot:
    _check_keys(path, told)
    description = urdf.read(urdf.located(told["urdf"], path.parent))
    arm, gripper = tuple(told["arm"]), tuple(told["gripper"]["joints"])
    for name in (*arm, *gripper):
        if name not in description.joints:
            listed = ", ".join(j.name for j in description.joints.values() if j.type != "fixed")
            raise UnusableRobot(f"{path}: no joint of the URDF is called '{name}'; there are {listed}")
    link = told["tool"]["link"]
    if link not in description.links:
        raise UnusableRobot(
            f"{path}: no link of the URDF is called '{link}'; there are {', '.join(description.links)}"
        )
    _check_chain(path, description, arm, link)
    limits = _limits(path, [description.joints[name] for name in arm], told.get("limits", {}))
    home = _numbers(path, "home", told["home"])
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
        _tool(path, told["tool"]),
        _workspace(path, told.get("workspace")),
    )
    _check_fingers(path, made)
    return made


def _numbers(path: Path, key: str, told: Any) -> Array:
    """(n,) finite ones."""
    try:
        found = np.array(told, dtype=float)
    except (TypeError, ValueError):
        found = np.array(math.nan)
    if found.ndim != 1 or not np.isfinite(found).all():
        raise UnusableRobot(f"{path}: `{key}` needs a list of numbers, found {told}")
    return found


def _workspace(path: Path, told: Any) -> Region | None:
    if told is None:
        return None
    try:
        (x0, x1), (y0, y1) = told
        region = ((float(x0), float(x1)), (float(y0), float(y1)))
    except (TypeError, ValueError) as unexpected:
        raise UnusableRobot(
            f"{path}: workspace is [[x from, x to], [y from, y to]] in metres, found {told}"
        ) from unexpected
    if not (x0 < x1 and y0 < y1):
        raise UnusableRobot(f"{path}: workspace needs ends that rise, found {told}")
    return region


def _check_keys(path: Path, told: Mapping[str, Any]) -> None:
    for table in filter(None, _TABLES):
        if not isinstance(told.get(table, {}), dict):
            raise UnusableRobot(f"{path}: [{table}] is a table, found {told[table]!r}")
    for table, allowed in _TABLES.items():
        found = told if not table else told.get(table, {})
        if unknown := sorted(set(found) - allowed):
            where = f"[{table}]" if table else "the top"
            raise UnusableRobot(f"{path}: {where} knows no '{unknown[0]}'; it takes {sorted(allowed)}")
    needed = [("", key) for key in ("urdf", "arm", "home", "tool", "gripper")]
    for table, key in [*needed, ("tool", "link"), ("gripper", "joints")]:
        if key not in (told[table] if table else told):
            raise UnusableRobot(f"{path}: '{key}' is missing{f' from [{table}]' if table else ''}")
    for key, text in (("urdf", told["urdf"]), ("link", told["tool"]["link"])):
        if not isinstance(text, str):
            raise UnusableRobot(f"{path}: '{key}' needs a text, found {text!r}")
    for key, names in (("arm", told["arm"]), ("joints", told["gripper"]["joints"])):
        if not isinstance(names, list) or not all(isinstance(name, str) for name in names):
            raise UnusableRobot(f"{path}: '{key}' needs a list of joints' names, found {names!r}")


def _check_chain(path: Path, description: Urdf, arm: tuple[str, ...], tool_link: str) -> None:
    """The arm's joints are those that lead to the tool, in this order."""
    moving = tuple(joint.name for joint in description.chain_to(tool_link) if joint.type != "fixed")
    if moving != arm:
        raise UnusableRobot(
            f"{path}: from the base to '{tool_link}' the URDF has the joints {list(moving)}, "
            f"'arm' says {list(arm)}; it must name the same in the same order"
        )


def _check_fingers(path: Path, made: Robot) -> None:
    for joint in made.finger_joints:
        if joint.child not in made.hand_links:
            raise UnusableRobot(f"{path}: the gripper joint '{joint.name}' is not on the arm's last link")
        if joint.mimic is None and (joint.lower is None or joint.upper is None or joint.lower >= joint.upper):
            raise UnusableRobot(f"{made.urdf.path}: the gripper joint '{joint.name}' has no limits")


def _limits(path: Path, joints: list[Joint], told: Mapping[str, Any]) -> Limits:
    """What the TOML says, else the URDF's; accelerations and jerks are rarely in a URDF."""

    def of(key: str, default: list[float | None]) -> Array:
        values: list[float | None] = default
        if key in told:
            values = list(_numbers(path, key, told[key]).tolist())
        for joint, value in zip(joints, values, strict=False):
            if value is None or not math.isfinite(value) or (key in POSITIVE and value <= 0):
                raise UnusableRobot(
                    f"{path}: joint '{joint.name}' has no {key} limit in the URDF (found {value}); "
                    f"give `{key}`, one number a joint, under [limits]"
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
                "give `lower` and `upper`, one number a joint, under [limits]"
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


def _tool(path: Path, told: Mapping[str, Any]) -> Array:
    """(4, 4) of the tool frame to its link, turned so that z approaches and y closes."""
    axes = {key: told.get(key, default) for key, default in (("approach", "z"), ("closing", "y"))}
    for key, axis in axes.items():
        if axis not in _AXES:
            raise UnusableRobot(f"{path}: '{key}' is one of {', '.join(_AXES)}, found {axis!r}")
    z, y = (np.array(_AXES[axis], float) for axis in axes.values())
    if abs(float(z @ y)) > 0.5:
        raise UnusableRobot(f"{path}: the gripper cannot close along its own approach")
    turned = np.array([np.cross(y, z), y, z]).T
    rpy, xyz = (_numbers(path, key, told.get(key, (0, 0, 0))) for key in ("rpy", "xyz"))
    if rpy.shape != (3,) or xyz.shape != (3,):
        raise UnusableRobot(f"{path}: `xyz` and `rpy` of the tool need three numbers, found {xyz}, {rpy}")
    link = transform_from(rotation_from_rpy(rpy), xyz)
    return link @ transform_from(turned, (0.0, 0.0, 0.0))
