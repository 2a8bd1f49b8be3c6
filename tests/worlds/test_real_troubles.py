"""What is wrong with a real robot's sensors, objects and hand, and what a run does about it."""

from __future__ import annotations

from dataclasses import replace
from math import dist, nan
from pathlib import Path

import numpy as np
import pytest

from ntp_dsl.core.one_core import shipped_core
from ntp_dsl.evaluation.episodes import Evaluator, Plan
from ntp_dsl.language.diagnostics.diagnostics import NtpError
from ntp_dsl.language.loader import load
from ntp_dsl.semantics.observation import Observation, SceneObject
from ntp_dsl.traces.overview import overview
from ntp_dsl.traces.reader import read_trace
from ntp_dsl.worlds.arm_bodies import bodies_of, with_spread
from ntp_dsl.worlds.catalogue import WITH_ARM, WORLDS, make_world
from ntp_dsl.worlds.observer import Observer, offset_of
from ntp_dsl.worlds.protocol import Disturbances, Scene, World

CUP = SceneObject("cup", "Cup", (0.05, 0.05, 0.06), "cylinder")
TABLE = SceneObject("table", "Table", (1.5, 1.5, 0.04))
SCENE = Scene((TABLE, CUP), {"table": (0.5, 0.0, -0.02), "cup": (0.5, 0.0, 0.03)})


def at(x: float) -> Observation:
    places = {"table": (0.5, 0.0, -0.02), "cup": (x, 0.0, 0.03)}
    return Observation((TABLE, CUP), places, (0.0, 0.0, 0.5), closed=False)


@pytest.mark.parametrize("latency, frames", [(0.1, 1), (0.2, 2), (0.25, 3), (0.3, 3), (0.5, 5)])
def test_a_late_observation_shows_what_was_so_long_ago(latency: float, frames: int) -> None:
    observer = Observer(0, Disturbances(latency=latency))
    times = [24 * k / 240 for k in range(12)]
    seen = [observer.observe(at(time), time).positions["cup"][0] for time in times]
    assert seen == [times[max(0, k - frames)] for k in range(12)]


@pytest.mark.parametrize("name", WORLDS)
def test_a_robot_waits_until_it_sees_what_came_of_a_call(name: str) -> None:
    """Whether or not somebody is told of the frames."""
    world, watched = made(name, Disturbances(latency=0.3)), made(name, Disturbances(latency=0.3))
    prompt = made(name, Disturbances())
    watched.on_frame = lambda _: None
    for call in (("move_to", ("cup",)), ("grasp", ("cup",)), ("grasp", ("cup",))):
        for each in (world, watched, prompt):
            each.call(*call)
        assert world.observe() == watched.observe()
        assert dist(world.observe().gripper, prompt.truth().gripper) < 1e-3
        assert world.observe().closed == prompt.truth().closed
    assert world.time > prompt.time + 0.8


def test_a_camera_that_is_off_shows_all_objects_off_alike_but_not_the_table() -> None:
    observer = Observer(3, Disturbances(camera_offset=0.004))
    shown = observer.observe(at(0.4), 0.0)
    assert dist(shown.positions["cup"], at(0.4).positions["cup"]) == pytest.approx(0.004)
    assert shown.positions["table"] == at(0.4).positions["table"]
    assert observer.observe(at(0.4), 9.0) == shown and not shown.deviations
    assert offset_of(3, 0.004) != offset_of(4, 0.004)


def test_masses_and_friction_are_off_by_the_share_at_most_and_by_the_seed() -> None:
    (body,) = bodies_of(SCENE)
    shares = [with_spread(body, seed, 0.2).mass / body.mass for seed in range(200)]
    assert 0.8 <= min(shares) < 0.82 and 1.18 < max(shares) <= 1.2
    assert (
        with_spread(body, 5, 0.2)
        == with_spread(body, 5, 0.2)
        != with_spread(replace(body, name="other"), 5, 0.2)
    )
    assert with_spread(body, 5, 0.0) is body


@pytest.mark.parametrize(
    "wrong",
    [{"latency": 0.6}, {"latency": nan}, {"camera_offset": -0.1}, {"spread": 1.0}, {"weak_grip": 1.0}],
)
def test_what_no_robot_has_is_refused(wrong: dict[str, float]) -> None:
    with pytest.raises(NtpError, match=next(iter(wrong))):
        Disturbances(**wrong)


def test_the_kinematic_world_has_neither_friction_nor_grip() -> None:
    world = make_world("kinematic", load("block_stacking"))
    for disturbances in (Disturbances(spread=0.1), Disturbances(weak_grip=0.5)):
        with pytest.raises(NtpError, match="--world bullet or mujoco"):
            world.reset(SCENE, 0, disturbances)


def made(name: str, disturbances: Disturbances, seed: int = 1) -> World:
    world = make_world(name, load("block_stacking"))
    world.reset(SCENE, seed, disturbances)
    return world


@pytest.mark.parametrize("name", WITH_ARM)
def test_a_camera_that_is_off_misleads_the_hand_as_well(name: str) -> None:
    seed = 2
    off = np.array(offset_of(seed, 0.006))
    assert np.linalg.norm(off[:2]) > 0.004
    world = made(name, Disturbances(camera_offset=0.006), seed)
    assert world.call("move_to", ("cup",)).achieved
    aside = np.subtract(world.truth().gripper, world.truth().positions["cup"])[:2]
    assert aside == pytest.approx(off[:2], abs=1.5e-3)


@pytest.mark.parametrize("name", WITH_ARM)
def test_a_hand_without_force_loses_what_a_strong_one_carries(name: str) -> None:
    held = []
    for weak_grip in (0.0, 0.995):
        world = made(name, Disturbances(weak_grip=weak_grip))
        held.append(world.call("move_to", ("cup",)).achieved and world.call("grasp", ("cup",)).achieved)
    assert held == [True, False]


@pytest.mark.parametrize("name", WITH_ARM)
def test_an_episode_with_all_of_it_is_done_and_its_trace_names_it(name: str, tmp_path: Path) -> None:
    trouble = Disturbances(noise=0.003, latency=0.1, camera_offset=0.002, spread=0.2, weak_grip=0.2)
    library = Path("block_stacking")
    plan = Plan(library, "block_stacking", None, name, 2, trouble, traces=tmp_path)
    evaluator = Evaluator(plan)
    assert evaluator.episode(0).success
    (path,) = tmp_path.glob("*.trace.jsonl")
    assert read_trace(path).header.disturbances == trouble


def test_a_failed_episode_tells_what_it_knew_nothing_of(tmp_path: Path) -> None:
    trouble = Disturbances(camera_offset=0.06)
    plan = Plan(
        Path("block_stacking"), "block_stacking", shipped_core(), "kinematic", 2, trouble, traces=tmp_path
    )
    assert not Evaluator(plan).episode(0).success
    (path,) = tmp_path.glob("*.trace.jsonl")
    assert any("seen 60 mm from where they were" in each for each in overview(read_trace(path)))
