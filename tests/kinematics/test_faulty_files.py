"""Faulty files of an arm: each fault is one sentence that names the place, and no silent hole of the arm."""

import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from kinematics_arms import elbow6, waist5

from kinematics.collision.models import MARGIN
from kinematics.collision.scene import CollisionScene
from kinematics.collision.scene_state import SceneState
from kinematics.collision.self_contact import always_touching
from kinematics.errors import UnusableRobot
from kinematics.geometry import urdf
from kinematics.geometry.bounded_files import MOST_DEPTH
from kinematics.geometry.transforms import transform_of
from kinematics.ik.global_ik import InverseKinematics
from kinematics.robot import gripper
from kinematics.robot.gripper import gripper_of
from kinematics.robot.robot import FOLDER, Robot, load
from kinematics.shapes.bodies import TABLE
from kinematics.simulation.bullet_cell import BulletCell
from kinematics.simulation.camera import Camera

Change = Callable[[str], str]
Write = Callable[[str | bytes | None, str | bytes | None], Robot]
DEEP = 100_000
HUGE = "1" + "0" * 400


@pytest.fixture
def texts(tmp_path: Path) -> tuple[str, str]:
    """Return the URDF and the TOML of `waist5`."""
    toml = waist5(tmp_path).read_text()
    return (tmp_path / "waist5.urdf").read_text(), toml


@pytest.fixture
def write(texts: tuple[str, str], tmp_path: Path) -> Write:
    """Return a function that loads `waist5` with another URDF or TOML."""

    def loaded(urdf: str | bytes | None, toml: str | bytes | None) -> Robot:
        for name, given, own in (("waist5.urdf", urdf, texts[0]), ("mine.toml", toml, texts[1])):
            content = own if given is None else given
            path = tmp_path / name
            path.write_bytes(content if isinstance(content, bytes) else content.encode())
        load.cache_clear()
        return load(str(tmp_path / "mine.toml"))

    return loaded


def instead(before: str, after: str) -> Change:
    def changed(text: str) -> str:
        assert before in text
        return text.replace(before, after, 1)

    return changed


def picture(robot: Robot) -> np.ndarray:
    camera = Camera(robot)
    joints = dict(zip(robot.arm_joints, robot.home.tolist(), strict=True))
    pixels = camera.picture({}, {}, joints, 160, 120, False)
    camera.close()
    return pixels


# -- Files that are no text, or too much of it ---------------------------------------------------------


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ("# é\nurdf = 'a'".encode("latin-1"), r"mine\.toml, line 1: it is not in UTF-8"),
        ("urdf = 'a'".encode("utf-16"), r"mine\.toml, line 1: it is not in UTF-8"),
        ("\nurdf = 'a\0'", r"mine\.toml, line 2: it has a NUL byte"),
        ("urdf = " + "[" * 9_000, "its lists or tables are nested too deeply"),
        ("urdf = " + "[" * DEEP, r"more than 20,000 bytes"),
        ("home = " + "1" * 5_000, "is not TOML: Exceeds the limit"),
        ("urdf." + ".".join(["a"] * 9_000) + " = 1", "'arm' is missing"),
        ('urdf = "\\u0000"', "is missing"),
    ],
)
def test_a_toml_that_cannot_be_read_is_a_sentence(content: str | bytes, message: str, write: Write) -> None:
    with pytest.raises(UnusableRobot, match=message):
        write(None, content)


@pytest.mark.parametrize(
    ("encoded", "message"),
    [
        (
            lambda u: u.replace("<link", "<!-- é -->\n<link", 1).encode("latin-1"),
            r"line 3: it is not in UTF-8",
        ),
        (lambda u: u.encode("utf-16"), r"line 1: it is not in UTF-8"),
        (lambda u: u.replace("</robot>", "\0</robot>").encode(), r"line 18: it has a NUL byte"),
        (lambda u: u.replace("</robot>", "<a>" * DEEP).encode(), f"nested more than {MOST_DEPTH} deep"),
        (lambda u: u.replace("</link>", "<a>" * DEEP, 1).encode(), f"line 3: .*more than {MOST_DEPTH} deep"),
        (lambda u: u.replace("</robot>", "<a/>" * DEEP).encode(), "more than 20,000 elements"),
        (lambda u: u.encode() + b" " * 10_000_000, "more than 10,000,000 bytes"),
        (lambda u: b'<!DOCTYPE a [<!ENTITY b "c">]><robot/>', "line 1: it declares an entity"),
        (lambda u: u.replace("</robot>", "").encode(), r"line 19: this is not XML: no element found"),
        (lambda u: b"", r"line 1: this is not XML: no element found"),
    ],
)
def test_a_urdf_that_cannot_be_read_is_a_sentence(
    encoded: Callable[[str], bytes], message: str, texts: tuple[str, str], write: Write
) -> None:
    with pytest.raises(UnusableRobot, match=message):
        write(encoded(texts[0]), None)


def test_a_byte_order_mark_is_no_fault(texts: tuple[str, str], write: Write) -> None:
    assert write(texts[0].encode("utf-8-sig"), texts[1].encode("utf-8-sig")).dof == 5


# -- Numbers, names and shapes -------------------------------------------------------------------------


@pytest.mark.parametrize("number", ["${h}", "-175deg", "nan", "inf", "1e400", HUGE, ""])
@pytest.mark.parametrize(
    ("attribute", "message"),
    [
        ('lower="-3.1"', "line 4: 'lower' of <limit> of joint 'waist' must be a number, found "),
        ('rpy="0 0 0"', "line 4: 'rpy' of <origin> of joint 'waist' must be 3 numbers, found "),
        ('axis xyz="0 0 1"', "line 4: 'xyz' of <axis> of joint 'waist' must be 3 numbers, found "),
        ('radius="0.07"', "line 3: 'radius' of <cylinder> of link 'base' must be a number, found "),
    ],
)
def test_what_is_no_number_in_a_urdf_names_line_and_element(
    attribute: str, message: str, number: str, texts: tuple[str, str], write: Write
) -> None:
    spoilt = re.sub(r'[^" ]+"$', f'{number}"', attribute)
    with pytest.raises(UnusableRobot, match=message) as found:
        write(instead(attribute, spoilt)(texts[0]), None)
    assert ("expand it with xacro" in str(found.value)) == (number == "${h}")


@pytest.mark.parametrize("number", ["nan", "inf", "1e400", HUGE, "true", '"1.0"', "[1.0]"])
def test_what_is_no_number_in_a_toml_names_the_key(number: str, texts: tuple[str, str], write: Write) -> None:
    with pytest.raises(UnusableRobot, match="`home` needs a list of numbers, found"):
        write(None, instead("1.44", number)(texts[1]))
    with pytest.raises(UnusableRobot, match="workspace"):
        write(None, f"workspace = [[0.3, {number}], [-0.2, 0.2]]\n{texts[1]}")


BOX = '<geometry><box size="0.1 0.1 0.1"/></geometry></visual>'


@pytest.mark.parametrize(
    ("before", "after", "message"),
    [
        ('size="0.1 0.1 0.1"', 'size="0.1 0.1 1e300"', "line 5: .* must be from 0 to 1000"),
        ('size="0.1 0.1 0.1"', 'size="0.1 0.1 -0.1"', "line 5: .* must be from 0 to 1000"),
        (' radius="0.07"', "", "line 3: <cylinder> of link 'base' lacks 'radius'"),
        (BOX, "<geometry><cone/></geometry></visual>", "line 5: <visual> of link 'body' must have one shape"),
        (BOX, "</visual>", "line 5: <visual> of link 'body' must have one shape of .*, found none"),
        (BOX, f"<geometry><sphere radius='1'/>{BOX[10:]}", "found <sphere>, <box>"),
        ('type="revolute"', 'type="rotary"', "line 4: joint 'waist' has the type 'rotary', not one of"),
        (
            'type="revolute"',
            'type="planar"',
            "joint 'waist' is planar; an arm has revolute or sliding joints",
        ),
        ('axis xyz="0 0 1"', 'axis xyz="0 0 0"', "line 4: the <axis> of joint 'waist' has no direction"),
        ('<link name="base"', "<link", "line 3: this link has no name"),
        ('<link name="base"', f'<link name="{"b" * 1_001}"', "line 3: .* an attribute of more than 1,000"),
        ("<link", '<material name="a"><color rgba="${r}"/></material><link', "'rgba' of <color> of material"),
        ("</robot>", '<link name="a"/>' * 500 + "</robot>", "it has 508 links; at most 500 are read"),
    ],
)
def test_what_libraries_would_read_differently_names_line_and_element(
    before: str, after: str, message: str, texts: tuple[str, str], write: Write
) -> None:
    with pytest.raises(UnusableRobot, match=message):
        write(instead(before, after)(texts[0]), None)


@pytest.mark.parametrize(
    ("before", "after", "message"),
    [
        ('urdf = "waist5.urdf"', 'urdf = "a\\u0000b"', r"there is no URDF at .*a\\x00b"),
        ('urdf = "waist5.urdf"', f'urdf = "{"a" * 5_000}"', "there is no URDF at"),
        ('urdf = "waist5.urdf"', 'urdf = "package://a.b/c"', "the Python package 'a.b' .* is not installed"),
        ('urdf = "waist5.urdf"', 'urdf = "\\u001b[2J\\n"', r"there is no URDF at [^\x1b\n]*$"),
        ('["finger_a"]', "[]", "'joints' must name one joint or more, each once"),
        ('["finger_a"]', '["finger_a", "finger_a"]', "'joints' must name one joint or more, each once"),
        ('["finger_a"]', '["wrist_rotate"]', "'wrist_rotate' is a joint of the arm and of the gripper"),
        ("[tool]", '[tool]\nclosing = ["y"]', "'closing' must be one of x, y, z, -x, -y, -z, found"),
        ("[tool]", 'without_collision = ["no"]\n[tool]', "`without_collision`: no link .* is called 'no'"),
        ("[tool]", 'allowed_collisions = [["base"]]\n[tool]', "`allowed_collisions` needs a list of pairs"),
        ("[tool]", 'allowed_collisions = [["base", 1]]\n[tool]', "`allowed_collisions` needs names of links"),
    ],
)
def test_a_fault_in_a_toml_is_a_sentence(
    before: str, after: str, message: str, texts: tuple[str, str], write: Write
) -> None:
    with pytest.raises(UnusableRobot, match=message):
        write(None, instead(before, after)(texts[1]))


def test_what_no_check_foresaw_is_a_sentence_that_asks_for_a_report(
    write: Write, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fails(*_: object) -> None:
        raise KeyError("a\nname")

    robot = write(None, None)
    monkeypatch.setattr(gripper, "_ends", fails)
    asks = (
        r"waist5\.urdf: no arm can be made of it \(KeyError: .*\); no check foresaw this, so please report it"
    )
    with pytest.raises(UnusableRobot, match=asks):
        gripper_of(robot)
    monkeypatch.setattr(urdf, "check_rules", fails)
    with pytest.raises(UnusableRobot, match=r"mine\.toml: no arm can be made of it \(KeyError"):
        write(None, None)


# -- What is unusual and sound -------------------------------------------------------------------------


def test_a_joint_and_a_link_may_have_one_name(texts: tuple[str, str], write: Write) -> None:
    plain = write(None, None)
    expected = InverseKinematics(plain).forward(plain.home)
    toml = instead("xyz = [0.0, 0.0, 0.1]\n", "")(texts[1]).replace('"wrist_rotate"', '"hand"')
    alike = write(texts[0].replace('"wrist_rotate"', '"hand"'), toml)
    hand = InverseKinematics(alike).forward(alike.home)
    assert np.allclose(hand[:3, 3] + 0.1 * hand[:3, 2], expected[:3, 3], atol=1e-9)


@pytest.mark.parametrize(
    "declared",
    [
        '<material name="red"><color rgba="1 0 0 1"/></material>',
        '<material name="red"><color rgba="1 0 0"/></material>' * 2,
    ],
)
def test_materials_before_the_links_colour_the_pictures(
    declared: str, texts: tuple[str, str], write: Write
) -> None:
    used = texts[0].replace("</visual>", '<material name="red"/></visual>')
    red = picture(write(instead("<link", f"{declared}<link")(used), None))
    assert (red != picture(write(texts[0], None))).any()


@pytest.mark.parametrize(
    "material", ["<material/>", '<material name="nowhere"/>', "<material><color/></material>"]
)
def test_a_material_without_a_colour_spoils_no_picture(
    material: str, texts: tuple[str, str], write: Write
) -> None:
    spoilt = write(texts[0].replace("</visual>", f"{material}</visual>"), None)
    assert np.array_equal(picture(spoilt), picture(write(texts[0], None)))


def test_a_urdf_on_one_line_is_the_same_arm_in_the_simulator(tmp_path: Path) -> None:
    """PyBullet breaks lines of more than 8,191 bytes anywhere, within numbers too."""
    path = elbow6(tmp_path)
    robot = load(str(path))
    written = tmp_path / "elbow6.urdf"
    ballast = "".join(
        f'<link name="x{k}"/><joint name="y{k}" type="fixed"><parent link="world"/>'
        f'<child link="x{k}"/></joint>'
        for k in range(60)
    )
    for spaces in range(0, 60, 7):
        body = written.read_text().split(">", 2)[2].replace("\n", "")
        one_line = path.with_name("line.urdf")
        one_line.write_text(f'<robot name="elbow6">{" " * spaces}{ballast}{body}')
        assert max(map(len, one_line.read_text().splitlines())) > 8_191
        path.with_name("line.toml").write_text(path.read_text().replace("elbow6.urdf", "line.urdf"))
        load.cache_clear()
        with BulletCell(load(str(path.with_name("line.toml")))) as cell:
            tool = transform_of(cell.tool_pose())
            assert np.allclose(tool, InverseKinematics(robot).forward(robot.home), atol=1e-3)
            assert picture(cell.robot).any()


# -- Silent holes of the arm ---------------------------------------------------------------------------

FOLDED = "[0.794, -0.812, -2.66, -3.022, 1.815, 3.424, 0.618]"


def panda_with(folder: Path, **changes: str) -> Robot:
    """Return the Panda with other values of TOML keys, or further ones."""
    text = (FOLDER / "panda.toml").read_text()
    for key, value in changes.items():
        text = re.sub(rf"^{key} = .*\n", "", text, flags=re.MULTILINE)
        text = f"{key} = {value}\n{text}"
    path = folder / "mine.toml"
    path.write_text(text)
    load.cache_clear()
    return load(str(path))


def test_a_home_in_self_collision_is_refused_and_names_the_links(tmp_path: Path) -> None:
    robot = panda_with(tmp_path, home=FOLDED)
    deepest = (
        "at `home` the arm is in collision with itself: 'panda_link0' and 'panda_hand' overlap by 104.9 mm"
    )
    with pytest.raises(UnusableRobot, match=deepest) as found:
        always_touching(robot)
    assert "'panda_link0' and 'panda_link6' are 2.5 mm apart (plans keep 4 mm)" in str(found.value)
    assert "give another `home`" in str(found.value) and "`allowed_collisions`" in str(found.value)
    with pytest.raises(UnusableRobot, match=deepest):  # before anything moves
        BulletCell(robot)


def test_no_posture_of_home_switches_checks_off(tmp_path: Path) -> None:
    """The pairs that are not checked depend on the arm alone; else a home is refused."""
    generator, limits = np.random.default_rng(0), load("panda").limits
    plain, refused = always_touching(load("panda")), 0
    for q in generator.uniform(limits.lower, limits.upper, (20, 7)):
        try:
            assert always_touching(panda_with(tmp_path, home=str(q.tolist()))) == plain
        except UnusableRobot:
            refused += 1
    assert 0 < refused < 20


def test_the_toml_allows_a_collision_that_is_a_flaw_of_the_meshes(tmp_path: Path) -> None:
    pairs = [f'["panda_hand", "panda_link{k}"]' for k in (0, 1)]
    pairs += [f'["panda_link{low}", "panda_link{high}"]' for low in (0, 1) for high in (6, 7)]
    pairs += [f'["panda_link0", "panda_{side}finger"]' for side in ("left", "right")]
    robot = panda_with(tmp_path, home=FOLDED, allowed_collisions=f"[{', '.join(pairs)}]")
    assert set(always_touching(robot)) - set(always_touching(load("panda"))) >= {
        ("panda_link0", "panda_hand")
    }
    state = SceneState({}, gripper_of(robot).maximum_opening)
    contacts = CollisionScene(robot, {}).contacts(robot.home, state)
    assert all(TABLE in contact.names for contact in contacts if contact.distance < MARGIN)


def test_links_that_can_be_seen_and_would_collide_with_nothing_are_refused(
    texts: tuple[str, str], write: Write
) -> None:
    hollow = re.sub(r'(<link name="(?:upper|fore)">.*?)<collision>.*?</collision>', r"\1", texts[0])
    with pytest.raises(UnusableRobot, match="<visual> and no <collision>, .* everything: upper, fore; give"):
        write(hollow, None)
    with pytest.raises(UnusableRobot, match="everything: fore; give"):
        write(hollow, f'without_collision = ["upper"]\n{texts[1]}')
    assert write(hollow, f'without_collision = ["upper", "fore"]\n{texts[1]}').dof == 5


def test_frames_need_neither_mass_nor_collision_geometry(texts: tuple[str, str], write: Write) -> None:
    frame = '<link name="eye"/><joint name="j" type="fixed"><parent link="hand"/><child link="eye"/></joint>'
    assert "eye" in write(instead("</robot>", f"{frame}</robot>")(texts[0]), None).hand_links
