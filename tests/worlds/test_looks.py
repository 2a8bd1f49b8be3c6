"""What is wrong with a real robot's sensors, objects and hand, and what a run does about it."""

from __future__ import annotations

from dataclasses import replace
from math import dist
from pathlib import Path

import numpy as np
import pytest

from ntp_dsl.evaluation.episodes import Evaluator, Plan
from ntp_dsl.language.diagnostics.diagnostics import NtpError
from ntp_dsl.language.loader import load
from ntp_dsl.semantics.observation import Observation, SceneObject
from ntp_dsl.traces.reader import read_trace
from ntp_dsl.worlds.arm_bodies import bodies_of, varied
from ntp_dsl.worlds.catalogue import WITH_ARM, make_world
from ntp_dsl.worlds.looks import Looks, camera_offset
from ntp_dsl.worlds.protocol import Disturbances, Scene, World

CUP = SceneObject("cup", "Cup", (0.05, 0.05, 0.06), "cylinder")
TABLE = SceneObject("table", "Table", (1.5, 1.5, 0.04))
SCENE = Scene((TABLE, CUP), {"table": (0.5, 0.0, -0.02), "cup": (0.5, 0.0, 0.03)})


def at(x: float) -> Observation:
    places = {"table": (0.5, 0.0, -0.02), "cup": (x, 0.0, 0.03)}
    return Observation((TABLE, CUP), places, (0.0, 0.0, 0.5), closed=False)


def test_a_late_look_shows_what_was_so_long_ago() -> None:
    looks = Looks(0, Disturbances(latency=0.25))
    seen = [looks.of(at(step / 10), step / 10).positions["cup"][0] for step in range(8)]
    assert seen == [0.0, 0.0, 0.0, 0.0, 0.1, 0.2, 0.3, 0.4]


def test_a_camera_that_is_off_shows_all_objects_off_alike_but_not_the_table() -> None:
    looks = Looks(3, Disturbances(camera=0.004))
    shown = looks.of(at(0.4), 0.0)
    assert dist(shown.positions["cup"], at(0.4).positions["cup"]) == pytest.approx(0.004)
    assert shown.positions["table"] == at(0.4).positions["table"]
    assert looks.of(at(0.4), 9.0) == shown and not shown.deviations
    assert camera_offset(3, 0.004) != camera_offset(4, 0.004)


def test_masses_and_friction_are_off_by_the_share_at_most_and_by_the_seed() -> None:
    (body,) = bodies_of(SCENE)
    shares = [varied(body, seed, 0.2).mass / body.mass for seed in range(200)]
    assert 0.8 <= min(shares) < 0.82 and 1.18 < max(shares) <= 1.2
    assert varied(body, 5, 0.2) == varied(body, 5, 0.2) != varied(replace(body, name="other"), 5, 0.2)
    assert varied(body, 5, 0.0) is body


NO_TIME = float("nan")


@pytest.mark.parametrize(
    "wrong", [{"latency": 0.6}, {"latency": NO_TIME}, {"camera": -0.1}, {"spread": 1.0}, {"weakness": 1.0}]
)
def test_what_no_robot_has_is_refused(wrong: dict[str, float]) -> None:
    with pytest.raises(NtpError, match=next(iter(wrong))):
        Disturbances(**wrong)


def test_the_kinematic_world_has_neither_friction_nor_grip() -> None:
    world = make_world("kinematic", load("block_stacking"))
    for disturbances in (Disturbances(spread=0.1), Disturbances(weakness=0.5)):
        with pytest.raises(NtpError, match=r"--world bullet or mujoco"):
            world.reset(SCENE, 0, disturbances)


def made(name: str, disturbances: Disturbances) -> World:
    world = make_world(name, load("block_stacking"))
    world.reset(SCENE, 1, disturbances)
    return world


@pytest.mark.parametrize("name", WITH_ARM)
def test_a_camera_that_is_off_misleads_the_hand_as_well(name: str) -> None:
    world = made(name, Disturbances(camera=0.006))
    off = np.array(camera_offset(1, 0.006))
    assert world.call("move_to", ("cup",)).achieved
    aside = np.subtract(world.truth().gripper, world.truth().positions["cup"])[:2]
    assert aside == pytest.approx(off[:2], abs=1.5e-3)


@pytest.mark.parametrize("name", WITH_ARM)
def test_a_hand_without_force_loses_what_a_strong_one_carries(name: str) -> None:
    held = []
    for weakness in (0.0, 0.995):
        world = made(name, Disturbances(weakness=weakness))
        held.append(world.call("move_to", ("cup",)).achieved and world.call("grasp", ("cup",)).achieved)
    assert held == [True, False]


@pytest.mark.parametrize("name", WITH_ARM)
def test_an_episode_with_all_of_it_is_done_and_its_trace_names_it(name: str, tmp_path: Path) -> None:
    trouble = Disturbances(noise=0.003, latency=0.1, camera=0.002, spread=0.2, weakness=0.2)
    library = Path("block_stacking")
    plan = Plan(library, "block_stacking", None, name, 2, trouble, traces=tmp_path)
    evaluator = Evaluator(plan)
    assert evaluator.episode(0).success
    (path,) = tmp_path.glob("*.trace.jsonl")
    assert read_trace(path).header.disturbances == trouble
