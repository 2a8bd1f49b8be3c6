"""An arm of one's own: a URDF and a short TOML; what is wrong with either is said, and where."""

import math
import re
from pathlib import Path

import numpy as np
import pytest

from kinematics.errors import UnusableRobot
from kinematics.geometry import urdf
from kinematics.robot.gripper import gripper_of
from kinematics.robot.robot import FOLDER, Robot, load

PANDA = urdf.located("package://pybullet_data/franka_panda/panda.urdf", Path())
ABSOLUTE = PANDA.read_text().replace("package://", f"{PANDA.parent}/")


def own(folder: Path, description: str = ABSOLUTE, **changes: tuple[str, str]) -> Robot:
    """The Panda as somebody's own arm, with changes to its URDF and to its TOML."""
    told = (FOLDER / "panda.toml").read_text().replace("package://pybullet_data/franka_panda/", "")
    for before, after in changes.values():
        assert before in told
        told = told.replace(before, after)
    (folder / "panda.urdf").write_text(description)
    (folder / "mine.toml").write_text(told)
    load.cache_clear()
    return load(str(folder / "mine.toml"))


def test_an_arm_of_ones_own_is_the_shipped_one_when_it_says_the_same(tmp_path: Path) -> None:
    mine, shipped = own(tmp_path), load("panda")
    assert mine.arm_joints == shipped.arm_joints and mine.dof == 7
    assert np.array_equal(mine.limits.lower, shipped.limits.lower)
    assert np.array_equal(gripper_of(mine).openings, gripper_of(shipped).openings)


def test_a_tool_may_be_told_by_its_place_on_another_link(tmp_path: Path) -> None:
    on_hand = '"panda_hand"\nxyz = [0.0, 0.0, 0.105]\nrpy = [0.0, 0.0, 0.0]'
    mine = own(tmp_path, tool=('"panda_grasptarget"', on_hand))
    from kinematics.ik.global_ik import InverseKinematics

    there, here = (InverseKinematics(robot).forward(mine.home) for robot in (mine, load("panda")))
    assert np.allclose(there, here, atol=1e-9)


def test_limits_that_the_urdf_lacks_may_stand_in_the_toml(tmp_path: Path) -> None:
    bare = re.sub(r"<limit [^>]*velocity=\"2[^>]*/>", "", ABSOLUTE)
    bare = re.sub(r"<safety_controller[^>]*/>", "", bare)
    with pytest.raises(UnusableRobot, match=r"panda_joint1.*no lower limit.*under \[limits\]"):
        own(tmp_path, bare)
    seven = ", ".join
    numbers = {"lower": "-2.8", "upper": "3.7", "velocity": "2.0", "effort": "50.0"}
    table = "[limits]\n" + "".join(f"{key} = [{seven([one] * 7)}]\n" for key, one in numbers.items())
    assert own(tmp_path, bare, limits=("[limits]\n", table)).limits.velocity[6] == 2.0


def test_a_joint_without_end_has_a_turn(tmp_path: Path) -> None:
    endless = ABSOLUTE.replace('"panda_joint7" type="revolute"', '"panda_joint7" type="continuous"')
    limits = own(tmp_path, endless).limits
    assert (limits.lower[6], limits.upper[6]) == (-math.pi, math.pi)


@pytest.mark.parametrize(
    ("before", "after", "message"),
    [
        ("collision/link3.obj", "collision/gone.obj", r"link 'panda_link3' wants the mesh .*gone\.obj"),
        ("visual/hand.obj", "visual/gone.obj", r"link 'panda_hand' wants the mesh .*gone\.obj"),
        ("<robot", "<model", "is no XML"),
        ('<link name="panda_link8"', "<xacro:arm/><link", "is a xacro that nobody expanded"),
        ('<link name="panda_link8"', '<link name="panda_link7"', "two links called 'panda_link7'"),
        ('<child link="panda_link4"/>', '<child link="elbow"/>', "'panda_joint4' needs a link 'elbow'"),
        ('<child link="panda_link4"/>', '<child link="panda_link3"/>', "must hang from one root"),
        ('<child link="panda_link4"/>', "", "joint 'panda_joint4' lacks"),
    ],
)
def test_a_urdf_that_cannot_be_used_is_told_by_link_or_joint(
    before: str, after: str, message: str, tmp_path: Path
) -> None:
    assert before in ABSOLUTE
    with pytest.raises(UnusableRobot, match=message):
        own(tmp_path, ABSOLUTE.replace(before, after))


@pytest.mark.parametrize(
    ("before", "after", "message"),
    [
        ('"panda_joint3"', '"elbow"', "no joint of the URDF is called 'elbow'"),
        ('"panda_grasptarget"', '"palm"', "no link of the URDF is called 'palm'"),
        ("panda.urdf", "other.urdf", "there is no URDF at"),
        ("home = [0.0, -0.4", "home = [9.0, -0.4", "home needs 7 joint positions within the limits"),
        ('"panda_joint2", ', "", "from the base to 'panda_grasptarget' the URDF has the joints"),
        ('closing = "y"', 'closing = "up"', "'closing' is one of x, y, z"),
        ('closing = "y"', 'closing = "z"', "cannot close along its own approach"),
        ("[tool]", "[hand]", "the top knows no 'hand'"),
        ("acceleration = [15.0, ", "acceleration = [", "`acceleration` needs 7 numbers, found 6"),
        ("home =", "home", "is no TOML"),
        ("arm = [", "arm = [7, ", "'arm' needs a list of joints' names, found"),
        ("joints = [", 'joints = "both" # ', "'joints' needs a list of joints' names, found 'both'"),
        ('link = "panda_grasptarget"', "link = 8", "'link' needs a text, found 8"),
        ("[limits]", "[[limits]]", r"\[limits\] is a table, found"),
        ("home = [0.0, ", 'home = ["left", ', "`home` needs a list of numbers"),
        ("acceleration = [15.0, ", "acceleration = [nan, ", "`acceleration` needs a list of numbers"),
        ("[tool]", "[tool]\nxyz = [0.0, 0.1]", "`xyz` and `rpy` of the tool need three numbers"),
        ("workspace = [[0.3, 0.7], ", "workspace = [", "workspace is .*in metres"),
        ("workspace = [[0.3, 0.7], ", "workspace = [[0.7, 0.3], ", "workspace needs ends that rise"),
    ],
)
def test_a_toml_that_cannot_be_used_is_told_by_key(
    before: str, after: str, message: str, tmp_path: Path
) -> None:
    with pytest.raises(UnusableRobot, match=message):
        own(tmp_path, change=(before, after))


def test_fingers_that_do_not_close_where_they_are_said_to_are_an_error(tmp_path: Path) -> None:
    mine = own(tmp_path, tool=('closing = "y"', 'closing = "x"'))
    with pytest.raises(UnusableRobot, match="not on either side of the tool"):
        gripper_of(mine)


def test_an_arm_that_nobody_knows_is_told_those_that_there_are() -> None:
    with pytest.raises(UnusableRobot, match="no arm is called 'pandas'.*panda, xarm6"):
        load("pandas")
