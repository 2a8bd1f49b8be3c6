"""The kinematic world: the same for a seed, and nothing in it hangs in the air."""

from __future__ import annotations

import numpy as np
import pytest

from ntp_dsl.language.loader import load
from ntp_dsl.semantics.geometry import Vector
from ntp_dsl.semantics.observation import Observation, SceneObject
from ntp_dsl.tasks.instances import draw, find_task
from ntp_dsl.worlds.grids import SPACING
from ntp_dsl.worlds.kinematic import KinematicWorld
from ntp_dsl.worlds.perturbed_starts import perturbed_start
from ntp_dsl.worlds.protocol import Disturbances, Failure, Scene
from ntp_dsl.worlds.scenes import movable
from ntp_dsl.worlds.starts import REGION, nominal_start

DISTURBED = Disturbances(slips=0.25, pushes=0.25, noise=0.002)
SIZE = (0.05, 0.05, 0.05)
THINGS = (
    *(SceneObject(name, "Block", SIZE) for name in "abc"),
    SceneObject("table", "Table", (1.5, 1.5, 0.04)),
)
PLACES: dict[str, Vector] = {
    "a": (0.4, 0.1, 0.025),
    "b": (0.5, 0.0, 0.025),
    "c": (0.6, -0.1, 0.025),
    "table": (0.5, 0.0, -0.02),
}


def world(seed: int = 0, disturbances: Disturbances | None = None, **scene: object) -> KinematicWorld:
    made = KinematicWorld()
    made.reset(Scene(THINGS, PLACES, **scene), seed, disturbances or Disturbances())  # type: ignore[arg-type]
    return made


def objects() -> tuple[SceneObject, ...]:
    registry = load("block_stacking")
    task = find_task(registry, "block_stacking")
    return draw(registry, task, np.random.default_rng(0)).objects


def blunder(seed: int) -> tuple[KinematicWorld, list[Observation]]:
    """Carry out random primitives from a perturbed start; yield the observations after each and meanwhile."""
    rng = np.random.default_rng(seed)
    made = KinematicWorld()
    made.reset(perturbed_start(objects(), rng), seed, DISTURBED)
    seen: list[Observation] = []
    made.on_frame = seen.append
    names = [obj.name for obj in objects()]
    for _ in range(30):
        target = str(rng.choice(names))
        made.call("move_to", (target,))
        api = "release" if target == "table" else str(rng.choice(["grasp", "release"]))
        made.call(api, (target,) if api == "grasp" else ())
        assert_nothing_floats(made.truth())
    return made, seen


def assert_nothing_floats(seen: Observation) -> None:
    """Assert that every object but the held one rests on the table or on an object right below it."""
    items = {obj.name: seen.positions[obj.name] for obj in movable(seen.objects)}
    tool = np.array(seen.gripper)
    for name, place in items.items():
        in_hand = seen.closed and np.linalg.norm(np.array(place) - tool) < 0.03
        if not in_hand and place[2] > 0.026:
            below = [np.array(place) - other for key, other in items.items() if key != name]
            assert any(abs(x) < 0.05 and abs(y) < 0.05 and abs(z - 0.05) < 2e-3 for x, y, z in below)


@pytest.mark.parametrize("seed", range(20))
def test_a_seed_gives_the_same_episode_bit_for_bit(seed: int) -> None:
    first, second = blunder(seed), blunder(seed)
    assert first[1] == second[1]
    assert (first[0].truth(), first[0].time) == (second[0].truth(), second[0].time)
    assert first[0].disturbed == second[0].disturbed


def test_another_seed_gives_another_episode() -> None:
    assert blunder(1)[1] != blunder(2)[1]


def test_what_is_held_follows_and_what_is_let_go_falls() -> None:
    made = world()
    assert made.call("move_to", ("a",)).achieved and made.call("grasp", ("a",)).achieved
    assert made.truth().closed and made.truth().positions["a"][2] > 0.1
    assert made.call("move_to", ("b",)).achieved and made.call("release", ()).achieved
    assert made.supported("a", "b") and not made.supported("b", "a")
    assert made.truth().positions["a"][2] == pytest.approx(0.075)


def test_time_passes_frame_by_frame() -> None:
    made, times = world(), [0.0]
    made.on_frame = lambda _: times.append(made.time)
    for api, target in [("move_to", "a"), ("grasp", "a"), ("move_to", "b")]:
        made.call(api, (target,))
    before = made.time
    made.settle(2.0)
    assert made.time == pytest.approx(before + 2.0)
    steps = np.diff([*times, made.time])
    assert (steps >= 0).all() and steps.max() < 0.101


def test_a_slip_is_said_and_leaves_the_hand_empty() -> None:
    made = world(disturbances=Disturbances(slips=1.0))
    made.call("move_to", ("a",))
    made.call("grasp", ("a",))
    outcome = made.call("move_to", ("c",))
    assert outcome.failure is Failure.OBJECT_DROPPED
    assert outcome.disturbances == ("slip a",) and made.disturbed == {"a"}
    assert not made.truth().closed
    assert_nothing_floats(made.truth())


def test_a_push_topples_what_was_built_and_says_so() -> None:
    made = world(disturbances=Disturbances(pushes=1.0))
    for api, arguments in [("move_to", ("a",)), ("grasp", ("a",)), ("move_to", ("b",))]:
        made.call(api, arguments)
    outcome = made.call("release", ())
    assert outcome.achieved and outcome.disturbances == ("push a",) and made.disturbed == {"a"}
    assert not made.supported("a", "b")


@pytest.mark.parametrize("share", [0.0, 0.25])
def test_slips_are_as_frequent_as_was_asked(share: float) -> None:
    slipped = 0
    for seed in range(400):
        made = world(seed, Disturbances(slips=share), held="a", gripper=(0.4, 0.1, 0.2))
        slipped += not made.call("move_to", ("c",)).achieved
    assert abs(slipped / 400 - share) < 0.07


def test_noise_is_seen_and_changes_nothing() -> None:
    made = world(disturbances=Disturbances(noise=0.003))
    truth = made.truth()
    shifts = [
        np.array(made.observe().positions[name]) - truth.positions[name] for _ in range(200) for name in "abc"
    ]
    assert np.std(shifts) == pytest.approx(0.003, rel=0.15)
    assert made.truth() == truth


@pytest.mark.parametrize(
    "api, arguments, reason",
    [
        ("move_to", ("nobody",), Failure.MISSING_OBJECT),
        ("grasp", ("nobody",), Failure.MISSING_OBJECT),
        ("grasp", ("a",), Failure.NOT_READY),
    ],
)
def test_what_cannot_be_done_is_said_with_a_reason(
    api: str, arguments: tuple[str, ...], reason: Failure
) -> None:
    made = world()
    before = made.truth().positions
    assert made.call(api, arguments).failure is reason
    assert made.truth().positions == before


@pytest.mark.parametrize("seed", range(20))
def test_objects_of_a_nominal_start_stand_apart_and_within_reach(seed: int) -> None:
    scene = nominal_start(objects(), np.random.default_rng(seed))
    places = np.array([scene.positions[obj.name][:2] for obj in movable(objects())])
    assert (places >= [REGION[0][0], REGION[1][0]]).all()
    assert (places <= [REGION[0][1], REGION[1][1]]).all()
    gaps = np.linalg.norm(places[:, None] - places, axis=-1) + np.eye(len(places))
    assert gaps.min() >= SPACING


def test_perturbed_starts_have_towers_buried_objects_and_full_hands() -> None:
    scenes = [perturbed_start(objects(), np.random.default_rng(seed)) for seed in range(100)]
    heights = [max(place[2] for place in scene.positions.values()) for scene in scenes]
    assert 10 < sum(scene.held is not None for scene in scenes) < 60
    assert sum(height > 0.12 for height in heights) > 30


def test_what_is_set_down_far_out_stays_there() -> None:
    """As in the Bullet world; only what falls off others or is pushed stays within the region."""
    made = world(gripper=(0.4, 0.1, 0.125), held=None)
    assert made.call("grasp", ("a",)) and made.move_over(0.5, 0.4) and made.call("release", ())
    assert made.truth().positions["a"] == pytest.approx((0.5, 0.4, 0.025), abs=0.005)
