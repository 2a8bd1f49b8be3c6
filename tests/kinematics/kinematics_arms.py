"""Invented arms, written link by link, each with peculiarities of real descriptions.

`elbow6` is made of boxes and cylinders, has a prefix in its names, a base that is turned and beside the
origin, three continuous joints, no masses, and one finger that mimics the other.
`sphere7` is made of STL meshes by `package://`, has a hand with its approach along x and its closing along
z, two fingers that open in opposite directions of the same axis, with pads as links of their own, and a
second, passive arm.
`waist5` has only five joints, and links that nearly touch in every configuration.
"""

import struct
from collections.abc import Callable
from pathlib import Path

Size = tuple[float, float, float]


def _numbers(values: tuple[float, ...]) -> str:
    return " ".join(f"{value:.6g}" for value in values)


def _link(name: str, *geometries: tuple[str, Size], mass: float | None = None) -> str:
    """Return a link with geometries at positions [m], with inertia if it has a mass."""
    parts = "".join(
        f'<{kind}><origin xyz="{_numbers(at)}"/><geometry>{geometry}</geometry></{kind}>'
        for geometry, at in geometries
        for kind in ("visual", "collision")
    )
    moments = 'ixx="0.01" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"'
    weight = "" if mass is None else f'<inertial><mass value="{mass}"/><inertia {moments}/></inertial>'
    return f'<link name="{name}">{parts}{weight}</link>\n'


def _joint(kind: str, names: str, at: Size, axis: Size = (0, 0, 1), more: str = "", yaw: float = 0) -> str:
    """Return a joint, given the names of joint, parent and child."""
    name, parent, child = names.split()
    return (
        f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>'
        f'<origin xyz="{_numbers(at)}" rpy="0 0 {yaw}"/><axis xyz="{_numbers(axis)}"/>{more}</joint>\n'
    )


def _limit(lower: float, upper: float, velocity: float = 2.5, effort: float = 100.0) -> str:
    return f'<limit lower="{lower}" upper="{upper}" velocity="{velocity}" effort="{effort}"/>'


def _box(x: float, y: float, z: float) -> str:
    return f'<box size="{x} {y} {z}"/>'


def _cylinder(radius: float, length: float) -> str:
    return f'<cylinder radius="{radius}" length="{length}"/>'


def elbow6(folder: Path) -> Path:
    p = "left_arm_"
    unlimited = '<limit velocity="2.5" effort="60"/>'
    slide = _limit(0, 0.05, 0.2, 40)
    description = [
        _link("world"),
        _joint("fixed", f"{p}mount world {p}base", (-0.05, 0.1, 0.02), yaw=0.5),
        _link(f"{p}base", (_cylinder(0.08, 0.1), (0, 0, 0.05))),
        _joint("continuous", f"{p}pan {p}base {p}shoulder", (0, 0, 0.12), more=unlimited),
        _link(f"{p}shoulder", (_box(0.12, 0.14, 0.14), (0, 0, 0.07))),
        _joint("revolute", f"{p}lift {p}shoulder {p}upper", (0, 0, 0.12), (0, 1, 0), _limit(-2.2, 2.2)),
        _link(f"{p}upper", (_box(0.08, 0.08, 0.3), (0, 0, 0.2))),
        _joint("revolute", f"{p}elbow {p}upper {p}fore", (0, 0, 0.38), (0, 1, 0), _limit(-2.6, 2.6)),
        _link(f"{p}fore", (_cylinder(0.035, 0.12), (0, 0, 0.1))),
        _joint("continuous", f"{p}roll {p}fore {p}wrist", (0, 0, 0.18), more=unlimited),
        _link(f"{p}wrist", (_cylinder(0.035, 0.12), (0, 0, 0.07))),
        _joint("revolute", f"{p}bend {p}wrist {p}neck", (0, 0, 0.18), (0, 1, 0), _limit(-2.1, 2.1)),
        _link(f"{p}neck", (_cylinder(0.03, 0.05), (0, 0, 0.035))),
        _joint("continuous", f"{p}turn {p}neck {p}flange", (0, 0, 0.08), more=unlimited),
        _link(f"{p}flange", (_cylinder(0.04, 0.02), (0, 0, 0.01))),
        _joint("fixed", f"{p}hand {p}flange {p}palm", (0, 0, 0.02)),
        _link(f"{p}palm", (_box(0.06, 0.18, 0.04), (0, 0, 0.02))),
        _joint("prismatic", f"{p}finger_a {p}palm {p}left", (0, 0, 0.04), (0, 1, 0), slide),
        _link(f"{p}left", (_box(0.022, 0.014, 0.07), (0, 0.007, 0.035))),
        _joint(
            "prismatic",
            f"{p}finger_b {p}palm {p}right",
            (0, 0, 0.04),
            (0, -1, 0),
            slide + f'<mimic joint="{p}finger_a"/>',
        ),
        _link(f"{p}right", (_box(0.022, 0.014, 0.07), (0, -0.007, 0.035))),
    ]
    joints = [f"{p}{name}" for name in ("pan", "lift", "elbow", "roll", "bend", "turn")]
    toml = f"""
urdf = "elbow6.urdf"
arm = {joints}
home = [-0.5, 0.3, 1.6, 0.0, 1.24, 0.0]
workspace = [[0.25, 0.5], [-0.1, 0.3]]
[tool]
link = "{p}palm"
xyz = [0.0, 0.0, 0.1]
approach = "z"
closing = "y"
[gripper]
joints = ["{p}finger_a"]
"""
    return _written(folder, "elbow6", description, toml)


def sphere7(folder: Path) -> Path:
    meshes = folder / "sphere7_description" / "meshes"
    meshes.mkdir(parents=True, exist_ok=True)

    def mesh(x: float, y: float, z: float) -> str:
        name = f"{round(1000 * x)}_{round(1000 * y)}_{round(1000 * z)}.stl"
        (meshes / name).write_bytes(_stl(1000 * x, 1000 * y, 1000 * z))  # in millimetres
        return f'<mesh filename="package://sphere7_description/meshes/{name}" scale="0.001 0.001 0.001"/>'

    turns = [("z", 2.9), ("y", 2.0), ("z", 2.9), ("y", 2.1), ("z", 2.9), ("y", 2.0), ("z", 3.0)]
    lengths = [0.16, 0.2, 0.2, 0.2, 0.2, 0.2, 0.09]
    description = [_link("pedestal", (mesh(0.16, 0.16, 0.1), (0, 0, 0.05)), mass=5.0)]
    parent = "pedestal"
    for k, ((axis, reach), length) in enumerate(zip(turns, lengths, strict=True)):
        along: Size = (0, 0, 1) if axis == "z" else (0, 1, 0)
        wide = 0.1 - 0.006 * k
        shape = mesh(wide, wide, 0.6 * lengths[k + 1]) if k < 6 else mesh(0.06, 0.06, 0.02)
        at: Size = (0, 0, 0.5 * lengths[k + 1]) if k < 6 else (0, 0, 0.01)
        limit = _limit(-reach, reach, 2.0, 120)
        description.append(_joint("revolute", f"j{k} {parent} l{k}", (0, 0, length), along, limit))
        parent = f"l{k}"
        description.append(_link(parent, (shape, at), mass=2.0 - 0.2 * k))
    look_along_x = '<origin xyz="0 0 0.02" rpy="0 -1.5707963268 0"/>'
    description += [
        f'<joint name="wrist" type="fixed"><parent link="l6"/><child link="hand"/>{look_along_x}</joint>\n',
        _link("hand", (mesh(0.05, 0.06, 0.2), (0.025, 0, 0)), mass=0.4),
        *_apart("left", "hand", (0.05, 0, 0.005), (0.0, 0.045), mesh),
        *_apart("right", "hand", (0.05, 0, -0.005), (-0.045, 0.0), mesh),
        _joint("revolute", "other_arm pedestal other", (-0.2, 0, 0.1), (0, 1, 0), _limit(-1, 1)),
        _link("other", (mesh(0.05, 0.05, 0.2), (0, 0, 0.1)), mass=1.0),
        "<gazebo reference='hand'><gravity>1</gravity></gazebo>\n",
        "<drake:note>a prefix that nothing declares</drake:note>\n",
    ]
    toml = f"""
urdf = "sphere7_description/urdf/sphere7.urdf"
arm = {[f"j{k}" for k in range(7)]}
home = [0.0, 0.3, 0.0, 1.5, 0.0, 1.34, 0.0]
[tool]
link = "hand"
xyz = [0.115, 0.0, 0.0]
approach = "x"
closing = "z"
[gripper]
joints = ["left_slide", "right_slide"]
[limits]
velocity = [1.5, 1.5, 1.5, 1.5, 2.0, 2.0, 2.0]
"""
    return _written(folder, "sphere7", description, toml, "sphere7_description/urdf/")


def waist5(folder: Path) -> Path:
    slide = _limit(0, 0.045, 0.2, 40)
    upright: Size = (0, 1, 0)
    description = [
        _link("base", (_cylinder(0.07, 0.1), (0, 0, 0.05))),
        _joint("revolute", "waist base body", (0, 0, 0.11), more=_limit(-3.1, 3.1)),
        _link("body", (_box(0.1, 0.1, 0.1), (0, 0, 0.042))),  # 2 mm above the base
        _joint("revolute", "shoulder body upper", (0, 0, 0.1), upright, _limit(-1.9, 1.9)),
        _link("upper", (_box(0.06, 0.06, 0.25), (0, 0, 0.17))),
        _joint("revolute", "elbow upper fore", (0, 0, 0.33), upright, _limit(-2.6, 2.6)),
        _link("fore", (_box(0.05, 0.05, 0.2), (0, 0, 0.15))),
        _joint("revolute", "wrist_pitch fore wrist", (0, 0, 0.3), upright, _limit(-2.2, 2.2)),
        _link("wrist", (_cylinder(0.03, 0.06), (0, 0, 0.05))),
        _joint("revolute", "wrist_rotate wrist hand", (0, 0, 0.1), more=_limit(-3.3, 3.3)),
        _link("hand", (_box(0.06, 0.16, 0.04), (0, 0, 0.02))),
        _joint("prismatic", "finger_a hand left", (0, 0, 0.04), (0, 1, 0), slide),
        _link("left", (_box(0.022, 0.012, 0.07), (0, 0.006, 0.035))),
        _joint(
            "prismatic", "finger_b hand right", (0, 0, 0.04), (0, -1, 0), slide + '<mimic joint="finger_a"/>'
        ),
        _link("right", (_box(0.022, 0.012, 0.07), (0, -0.006, 0.035))),
    ]
    toml = """
urdf = "waist5.urdf"
arm = ["waist", "shoulder", "elbow", "wrist_pitch", "wrist_rotate"]
home = [0.0, 0.2, 1.5, 1.44, 0.0]
[tool]
link = "hand"
xyz = [0.0, 0.0, 0.1]
[gripper]
joints = ["finger_a"]
"""
    return _written(folder, "waist5", description, toml)


def _apart(
    name: str, parent: str, at: Size, ends: tuple[float, float], mesh: Callable[..., str]
) -> list[str]:
    """Return a finger whose pad is a link of its own."""
    side = 1.0 if ends[1] > 0 else -1.0
    return [
        _joint("prismatic", f"{name}_slide {parent} {name}_jaw", at, (0, 0, 1), _limit(*ends, 0.2, 50)),
        _link(f"{name}_jaw", (mesh(0.03, 0.02, 0.012), (0.015, 0, side * 0.006)), mass=0.05),
        _joint("fixed", f"{name}_tip {name}_jaw {name}_pad", (0.03, 0, 0)),
        _link(f"{name}_pad", (mesh(0.045, 0.02, 0.01), (0.0225, 0, side * 0.001)), mass=0.02),
    ]


def _stl(x: float, y: float, z: float) -> bytes:
    """Return a cuboid as a binary STL."""
    corners = [(a * x / 2, b * y / 2, c * z / 2) for a in (-1, 1) for b in (-1, 1) for c in (-1, 1)]
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    triangles = [three for a, b, c, d in quads for three in ((a, b, c), (a, c, d))]
    faces = b"".join(
        struct.pack("<12fH", 0.0, 0.0, 0.0, *(v for corner in three for v in corners[corner]), 0)
        for three in triangles
    )
    return b"solid no more".ljust(80) + struct.pack("<I", len(triangles)) + faces


def _written(folder: Path, name: str, description: list[str], toml: str, within: str = "") -> Path:
    path = folder / within / f"{name}.urdf"
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(f'<?xml version="1.0"?>\n<robot name="{name}">\n{"".join(description)}</robot>\n')
    path_of_toml = folder / f"{name}.toml"
    path_of_toml.write_text(toml)
    return path_of_toml


WRITTEN: dict[str, Callable[[Path], Path]] = {"elbow6": elbow6, "sphere7": sphere7, "waist5": waist5}
