"""The Panda of `pybullet_data`, as Pinocchio, MuJoCo (for mink too) and PyBullet read it.

Lengths in metres, angles in radians, the robot's base at the world's origin. The tool frame sits
between
the fingertips: z along the approach, y along the closing direction.
"""

import importlib.util
import re
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pinocchio

from kinematics.geometry import Array

ARM_JOINTS = tuple(f"panda_joint{i}" for i in range(1, 8))
TOOL_FRAME = "panda_grasptarget"
FINGER_LINKS = ("panda_leftfinger", "panda_rightfinger")
HAND_LINKS = ("panda_hand", *FINGER_LINKS)
MAXIMUM_OPENING = 0.04  # of one finger from the middle [m]
TOOL_FROM_HAND = 0.105  # along the approach [m]
FINGERTIP_BEYOND_TOOL = 0.0073  # [m]

SHOULDER = np.array([0.0, 0.0, 0.333])  # where the first two axes meet [m]
REACH = 0.95  # of the tool from the shoulder: all links in a line come to 0.949 [m]

HOME = np.array([0.0, -0.4, 0.0, -2.2, 0.0, 1.8, 0.785398163397])  # tool down, in front of the base
ACCELERATION = np.array([15.0, 7.5, 10.0, 12.5, 15.0, 20.0, 20.0])  # published by Franka [rad/s2]


@dataclass(frozen=True)
class Limits:
    """Soft limits of the seven arm joints."""

    lower: Array  # [rad]
    upper: Array  # [rad]
    velocity: Array  # [rad/s]
    effort: Array  # [N m]

    def contains(self, q: Array, tolerance: float = 1e-9) -> bool:
        return bool((q >= self.lower - tolerance).all() and (q <= self.upper + tolerance).all())


def folder() -> Path:
    """Where `pybullet_data` keeps the robot. Found without importing it, so that nothing is
    printed.
    """
    spec = importlib.util.find_spec("pybullet_data")
    if spec is None or spec.origin is None:
        raise FileNotFoundError("the package pybullet_data (part of pybullet) is not installed")
    return Path(spec.origin).parent / "franka_panda"


@cache
def description() -> str:
    """The robot's URDF, as shipped."""
    return (folder() / "panda.urdf").read_text()


@cache
def limits() -> Limits:
    """The soft limits of the `safety_controller` elements: the `limit` elements are wider than the
    maker's.
    """
    joints = [_joint_text(name) for name in ARM_JOINTS]
    return Limits(
        lower=_numbers(joints, r'soft_lower_limit="([^"]+)"'),
        upper=_numbers(joints, r'soft_upper_limit="([^"]+)"'),
        velocity=_numbers(joints, r' velocity="([^"]+)"'),
        effort=_numbers(joints, r' effort="([^"]+)"'),
    )


def _joint_text(name: str) -> str:
    found = re.search(rf'<joint name="{name}".*?</joint>', description(), flags=re.S)
    assert found is not None, name
    return found.group()


def _numbers(texts: list[str], pattern: str) -> Array:
    found = [re.search(pattern, text) for text in texts]
    return np.array([float(match.group(1)) for match in found if match is not None])


def _with_fixed_fingers(text: str) -> str:
    """Without the finger joints: as a mimic pair they would cost an equality in every update."""
    text = re.sub(r"<mimic[^>]*/>", "", text)
    return re.sub(r'(<joint name="panda_finger_joint\d" type=)"prismatic"', r'\1"fixed"', text)


def description_for_bullet() -> str:
    """Without visuals, which make loading six times slower, and with absolute paths."""
    text = re.sub(r"<visual>.*?</visual>", "", description(), flags=re.S)
    return text.replace("package://", f"{folder()}/")


def mujoco_spec() -> Any:
    """The arm with fixed fingers as an editable MuJoCo description, joint ranges tightened."""
    options = (
        f'<mujoco><compiler strippath="false" meshdir="{folder()}" balanceinertia="true" '
        'discardvisual="true" fusestatic="false"/></mujoco>'
    )
    text = _with_fixed_fingers(description()).replace("package://", "")
    text = re.sub(r"(<robot[^>]*>)", lambda match: match.group(1) + options, text, count=1)
    spec = mujoco.MjSpec.from_string(text)
    for name, lower, upper in zip(ARM_JOINTS, limits().lower, limits().upper, strict=True):
        spec.joint(name).range = [lower, upper]
    return spec


@cache
def mujoco_model() -> Any:
    """The arm alone, for mink."""
    return mujoco_spec().compile()


@cache
def pinocchio_model() -> Any:
    """The arm alone, for Pinocchio."""
    model = pinocchio.buildModelFromXML(_with_fixed_fingers(description()))
    model.lowerPositionLimit = limits().lower.copy()
    model.upperPositionLimit = limits().upper.copy()
    return model
