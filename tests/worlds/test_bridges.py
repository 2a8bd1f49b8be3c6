"""What lies across two objects rests on both, and what is let go over something comes to rest on it."""

from __future__ import annotations

import pytest

from ntp_dsl.language.loader import load
from ntp_dsl.semantics.geometry import Vector
from ntp_dsl.semantics.observation import SceneObject
from ntp_dsl.worlds.catalogue import make_world
from ntp_dsl.worlds.kinematic import KinematicWorld
from ntp_dsl.worlds.protocol import Scene

PILLAR, PLANK, TRAY = (0.04, 0.04, 0.04), (0.04, 0.16, 0.02), (0.2, 0.2, 0.01)
THINGS = (
    SceneObject("table", "Table", (1.5, 1.5, 0.04)),
    SceneObject("left", "Place", PILLAR, fixed=True),
    SceneObject("right", "Place", PILLAR, fixed=True),
    SceneObject("tray", "Place", TRAY, fixed=True),
    SceneObject("plank", "Movable", PLANK),
)
PLACES: dict[str, Vector] = {
    "table": (0.5, 0.0, -0.02),
    "left": (0.45, 0.06, 0.02),
    "right": (0.45, -0.06, 0.02),
    "tray": (0.5, 0.32, 0.005),
    "plank": (0.6, -0.2, 0.01),
}
MIDDLE = (0.45, 0.0)


@pytest.mark.parametrize("world", ["kinematic", "bullet", "mujoco"])
@pytest.mark.parametrize("place, height", [(MIDDLE, 0.05), ((0.52, 0.3), 0.02), ((0.6, 0.05), 0.01)])
def test_a_plank_comes_to_rest_on_what_is_below_it(
    world: str, place: tuple[float, float], height: float
) -> None:
    made = make_world(world, load("block_stacking"))
    made.reset(Scene(THINGS, PLACES, {"plank": 0.5}), seed=0)
    for api, arguments in (("move_to", ("plank",)), ("grasp", ("plank",))):
        assert made.call(api, arguments).achieved
    outcome = made.move_over(*place)
    assert outcome.achieved, outcome
    assert made.call("release", ()).achieved
    made.settle(1.0)
    assert made.truth().positions["plank"] == pytest.approx((*place, height), abs=5e-3)


@pytest.mark.parametrize("beyond", [0.0, 0.03, 0.07, 0.09, 0.2])
def test_what_is_not_balanced_falls(beyond: float) -> None:
    made = KinematicWorld(placement_error=0.0)
    over: Vector = (MIDDLE[0], beyond, 0.2)
    made.reset(Scene(THINGS, PLACES | {"plank": over}, gripper=over, held="plank"), seed=0)
    assert made.call("release", ()).achieved
    rests = made.truth().positions["plank"][2]
    balanced = beyond < 0.08  # the outer edge of the left pillar
    assert rests == pytest.approx(0.05 if balanced else 0.01)
