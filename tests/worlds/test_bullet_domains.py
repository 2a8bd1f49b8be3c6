"""The arm's world carries out every example by its expert, and says what it cannot make."""

from __future__ import annotations

from pathlib import Path

import pytest

from kinematics.shapes import catalogue
from ntp_dsl.common.resources import examples_folder
from ntp_dsl.evaluation.episodes import Evaluator, Plan
from ntp_dsl.language.diagnostics.diagnostics import NtpError
from ntp_dsl.semantics.observation import SceneObject
from ntp_dsl.worlds.arm_bodies import bodies_of, shape_of
from ntp_dsl.worlds.protocol import Disturbances, Scene

TABLE = SceneObject("table", "Table", (1.5, 1.5, 0.04))
TASKS = [
    ("object_sorting", "object_sorting", Disturbances()),
    ("table_cleanup", "three_and_three", Disturbances()),
    ("serving", "serving", Disturbances()),
    ("seating", "changing_places", Disturbances(slips=0.25)),
    ("blueprint", "blueprint", Disturbances()),
]


@pytest.mark.parametrize("library, task, disturbances", TASKS)
def test_an_expert_does_an_example_with_the_arm(library: str, task: str, disturbances: Disturbances) -> None:
    plan = Plan(examples_folder() / library, task, None, "bullet", disturbances=disturbances)
    episode = Evaluator(plan).episode(0)
    assert episode.success, episode.reason


def test_what_stays_has_no_mass_and_a_colour_is_what_the_scene_says() -> None:
    objects = (
        TABLE,
        SceneObject("pad", "Place", (0.07, 0.07, 0.01), fixed=True),
        SceneObject("cup", "Cup", (0.05, 0.05, 0.06), "cylinder", traits=(("colour", "blue"),)),
    )
    scene = Scene(objects, {obj.name: (0.5, 0.0, 0.1) for obj in objects})
    pad, cup = bodies_of(scene)
    assert pad.is_fixed and not cup.is_fixed
    assert cup.colour[2] > max(cup.colour[:2])


@pytest.mark.parametrize(
    "obj, told",
    [
        (
            SceneObject("dish", "Bowl", (0.03, 0.03, 0.02), "bowl"),
            "a bowl of 3 x 3 x 2 cm, which cannot be made",
        ),
        (SceneObject("cup", "Cup", (0.05, 0.05, 0.06), "mesh", "no.obj"), "there is no such file"),
    ],
)
def test_what_cannot_be_made_is_said(obj: SceneObject, told: str) -> None:
    with pytest.raises(NtpError, match=told):
        shape_of(obj)


def test_a_urdf_has_the_extents_that_the_scene_says(tmp_path: Path) -> None:
    path = tmp_path / "cup.urdf"
    box = '<collision><geometry><box size="0.05 0.04 0.06"/></geometry></collision>'
    path.write_text(f'<robot name="cup"><link name="cup">{box}</link></robot>')
    assert shape_of(SceneObject("cup", "Cup", (0.05, 0.04, 0.06), "urdf", str(path)))
    with pytest.raises(NtpError, match="measures 5.0 cm, 4.0 cm, 6.0 cm"):
        shape_of(SceneObject("cup", "Cup", (0.09, 0.04, 0.06), "urdf", str(path)))


def test_the_fork_of_the_table_cleanup_is_that_of_the_arms_own_tests() -> None:
    """Its shape, its handle, its mass and its colour come from the file beside the library."""
    path = examples_folder() / "table_cleanup" / "fork.urdf"
    fork = SceneObject("fork", "Fork", (0.1, 0.018, 0.006), "urdf", str(path))
    (body,) = bodies_of(Scene((fork,), {"fork": (0.5, 0.0, 0.003)}))
    assert body.shape == catalogue.fork(0.1, 0.006)
    assert (body.mass, body.colour) == (0.02, (0.50, 0.53, 0.57, 1.0))


@pytest.mark.parametrize("mass", ["0", "-1", "inf", "heavy"])
def test_a_mass_that_cannot_be_is_named(tmp_path: Path, mass: str) -> None:
    path = tmp_path / "cup.urdf"
    box = '<collision><geometry><box size="0.05 0.04 0.06"/></geometry></collision>'
    inertial = f'<inertial><mass value="{mass}"/></inertial>'
    path.write_text(f'<robot name="cup"><link name="cup">{inertial}{box}</link></robot>')
    cup = SceneObject("cup", "Cup", (0.05, 0.04, 0.06), "urdf", str(path))
    with pytest.raises(NtpError, match="cup cannot be made of"):
        bodies_of(Scene((cup,), {"cup": (0.5, 0.0, 0.03)}))
