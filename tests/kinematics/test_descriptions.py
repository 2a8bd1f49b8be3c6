"""Custom arms, by a URDF and a short TOML; errors in either name the place."""

import math
import re
from pathlib import Path

import numpy as np
import pytest

from kinematics.errors import UnusableRobot
from kinematics.robot.gripper import gripper_of
from kinematics.robot.robot import FOLDER, Robot, load

PANDA = FOLDER / "panda" / "panda.urdf"
ABSOLUTE = PANDA.read_text().replace("collision/", f"{PANDA.parent}/collision/")


def custom_arm(folder: Path, description: str = ABSOLUTE, **changes: tuple[str, str]) -> Robot:
    """Return the Panda as a custom arm, with changes to its URDF and its TOML."""
    toml = (FOLDER / "panda.toml").read_text().replace("package://kinematics/robots/panda/", "")
    for before, after in changes.values():
        assert before in toml
        toml = toml.replace(before, after)
    (folder / "panda.urdf").write_text(description)
    (folder / "mine.toml").write_text(toml)
    load.cache_clear()
    return load(str(folder / "mine.toml"))


def test_a_custom_arm_with_the_panda_s_description_equals_the_panda(tmp_path: Path) -> None:
    custom, shipped = custom_arm(tmp_path), load("panda")
    assert custom.arm_joints == shipped.arm_joints and custom.dof == 7
    assert np.array_equal(custom.limits.lower, shipped.limits.lower)
    assert np.array_equal(gripper_of(custom).openings, gripper_of(shipped).openings)


def test_a_tool_may_be_given_by_its_pose_on_another_link(tmp_path: Path) -> None:
    on_hand = '"panda_hand"\nxyz = [0.0, 0.0, 0.105]\nrpy = [0.0, 0.0, 0.0]'
    custom = custom_arm(tmp_path, tool=('"panda_grasptarget"', on_hand))
    from kinematics.ik.global_ik import InverseKinematics

    there, here = (InverseKinematics(robot).forward(custom.home) for robot in (custom, load("panda")))
    assert np.allclose(there, here, atol=1e-9)


def test_the_toml_may_give_limits_that_the_urdf_lacks(tmp_path: Path) -> None:
    bare = re.sub(r"<limit [^>]*velocity=\"2[^>]*/>", "", ABSOLUTE)
    bare = re.sub(r"<safety_controller[^>]*/>", "", bare)
    with pytest.raises(UnusableRobot, match=r"panda_joint1.*no lower limit.*under \[limits\]"):
        custom_arm(tmp_path, bare)
    seven = ", ".join
    numbers = {"lower": "-2.8", "upper": "3.7", "velocity": "2.0", "effort": "50.0"}
    table = "[limits]\n" + "".join(f"{key} = [{seven([one] * 7)}]\n" for key, one in numbers.items())
    assert custom_arm(tmp_path, bare, limits=("[limits]\n", table)).limits.velocity[6] == 2.0


def test_a_continuous_joint_is_limited_to_one_turn(tmp_path: Path) -> None:
    continuous = ABSOLUTE.replace('"panda_joint7" type="revolute"', '"panda_joint7" type="continuous"')
    limits = custom_arm(tmp_path, continuous).limits
    assert (limits.lower[6], limits.upper[6]) == (-math.pi, math.pi)


@pytest.mark.parametrize(
    ("before", "after", "message"),
    [
        ("collision/link3.obj", "collision/gone.obj", r"link 'panda_link3' .* missing mesh .*gone\.obj"),
        ("visual/hand.obj", "visual/gone.obj", r"link 'panda_hand' .* missing mesh .*gone\.obj"),
        ("<robot", "<model", "is not XML"),
        ('<link name="panda_link8"', "<xacro:arm/><link", "is an unexpanded xacro"),
        ('<link name="panda_link8"', '<link name="panda_link7"', "two links called 'panda_link7'"),
        ('<child link="panda_link4"/>', '<child link="elbow"/>', "'panda_joint4' .* missing link 'elbow'"),
        ('<child link="panda_link4"/>', '<child link="panda_link3"/>', "must form one tree with one root"),
        ('<child link="panda_link4"/>', "", "joint 'panda_joint4' lacks"),
    ],
)
def test_an_error_in_a_urdf_names_the_link_or_joint(
    before: str, after: str, message: str, tmp_path: Path
) -> None:
    assert before in ABSOLUTE
    with pytest.raises(UnusableRobot, match=message):
        custom_arm(tmp_path, ABSOLUTE.replace(before, after))


@pytest.mark.parametrize(
    ("before", "after", "message"),
    [
        ('"panda_joint3"', '"elbow"', "no joint of the URDF is called 'elbow'"),
        ('"panda_grasptarget"', '"palm"', "no link of the URDF is called 'palm'"),
        ("panda.urdf", "other.urdf", "there is no URDF at"),
        ("home = [0.0, -0.4", "home = [9.0, -0.4", "home needs 7 joint positions within the limits"),
        ('"panda_joint2", ', "", "from the base to 'panda_grasptarget' the URDF has the joints"),
        ('closing = "y"', 'closing = "up"', "'closing' must be one of x, y, z"),
        ('closing = "y"', 'closing = "z"', "cannot close along its own approach"),
        ("[tool]", "[hand]", "the top level has no key 'hand'"),
        ("acceleration = [15.0, ", "acceleration = [", "`acceleration` needs 7 numbers, found 6"),
        ("home =", "home", "is not TOML"),
        ("arm = [", "arm = [7, ", "'arm' needs a list of joint names, found"),
        ("joints = [", 'joints = "both" # ', "'joints' needs a list of joint names, found 'both'"),
        ('link = "panda_grasptarget"', "link = 8", "'link' needs a string, found 8"),
        ("[limits]", "[[limits]]", r"\[limits\] must be a table, found"),
        ("home = [0.0, ", 'home = ["left", ', "`home` needs a list of numbers"),
        ("acceleration = [15.0, ", "acceleration = [nan, ", "`acceleration` needs a list of numbers"),
        ("[tool]", "[tool]\nxyz = [0.0, 0.1]", "`xyz` and `rpy` of the tool need three numbers"),
        ("workspace = [[0.3, 0.7], ", "workspace = [", "workspace is .*in metres"),
        ("workspace = [[0.3, 0.7], ", "workspace = [[0.7, 0.3], ", "workspace needs increasing limits"),
    ],
)
def test_an_error_in_a_toml_names_the_key(before: str, after: str, message: str, tmp_path: Path) -> None:
    with pytest.raises(UnusableRobot, match=message):
        custom_arm(tmp_path, change=(before, after))


def test_fingers_that_do_not_close_along_the_closing_axis_are_an_error(tmp_path: Path) -> None:
    custom = custom_arm(tmp_path, tool=('closing = "y"', 'closing = "x"'))
    with pytest.raises(UnusableRobot, match="not on either side of the tool"):
        gripper_of(custom)


def test_the_error_for_an_unknown_arm_lists_the_known_ones() -> None:
    message = "'pandas' is neither an arm nor a file; the arms are panda, xarm6"
    with pytest.raises(UnusableRobot, match=message):
        load("pandas")
