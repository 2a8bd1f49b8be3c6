"""Free space and containment, as the predicates and both worlds see them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ntp_dsl.semantics.containers import contents, lies_in, takes
from ntp_dsl.semantics.free_space import (
    FREE_GAP,
    clearance,
    free_places,
    place_in,
    rank_places,
    region_within,
)
from ntp_dsl.semantics.geometry import Vector
from ntp_dsl.semantics.observation import Observation, SceneObject
from ntp_dsl.semantics.predicates import above, inside
from ntp_dsl.worlds.kinematic import KinematicWorld
from ntp_dsl.worlds.places import table_regions
from ntp_dsl.worlds.protocol import Scene

TABLE = SceneObject("table", "Table", (1.5, 1.5, 0.04))
TRAY = SceneObject("tray", "Tray", (0.2, 0.16, 0.02), fixed=True)
BOWL = SceneObject("bowl", "Bowl", (0.144, 0.144, 0.06), "bowl")
BIN = SceneObject("bin", "Bin", (0.2, 0.16, 0.08), "bin", fixed=True)
HAND: Vector = (0.5, 0.0, 0.3)
lengths = st.floats(0.01, 0.2)
places = st.tuples(st.floats(0.3, 0.7), st.floats(-0.2, 0.2))


def cube(name: str) -> SceneObject:
    return SceneObject(name, "Block", (0.05, 0.05, 0.05))


@given(places, st.tuples(lengths, lengths), st.lists(st.tuples(places, st.tuples(lengths, lengths))))
def test_a_clearance_is_the_least_gap_to_another_footprint(
    at: tuple[float, float],
    size: tuple[float, float],
    others: list[tuple[tuple[float, float], tuple[float, float]]],
) -> None:
    gaps = [
        max(abs(at[axis] - centre[axis]) - (size[axis] + extent[axis]) / 2 for axis in (0, 1))
        for centre, extent in others
    ]
    assert float(clearance(at, size, others)) == pytest.approx(min(gaps, default=np.inf))
    assert clearance([at, at], size, others).shape == (2,)


@pytest.mark.parametrize("surface", ["table", "tray"])
@pytest.mark.parametrize("seed", range(5))
def test_an_object_may_be_put_down_wherever_there_is_a_free_place(surface: str, seed: int) -> None:
    rng = np.random.default_rng(seed)
    names = [f"block_{number}" for number in range(8)]
    objects = (*map(cube, names), TRAY, TABLE)
    x, y = rng.uniform(0.3, 0.6, 7), rng.uniform(-0.2, 0.2, 7)
    standing = {name: (float(a), float(b), 0.025) for name, a, b in zip(names[1:], x, y, strict=True)}
    positions = {"block_0": HAND, "tray": (0.5, 0.3, 0.01), "table": (0.5, 0.0, -0.02), **standing}
    regions = table_regions(Scene(objects, positions, held="block_0"))
    seen = Observation(objects, positions, HAND, closed=True)
    found = free_places(seen, surface, regions)
    assert found
    for x0, y0 in found:
        over = {**positions, "block_0": (x0, y0, 0.3)}
        assert above(replace(seen, positions=over, gripper=(x0, y0, 0.3)), "gripper", surface)


def test_the_clearest_place_comes_first_and_of_equals_the_nearest_to_the_middle() -> None:
    alone, _ = rank_places(((0.3, 0.7), (-0.2, 0.2)), (0.05, 0.05), [])
    assert alone[0] == pytest.approx((0.5, 0.0))
    beside, room = rank_places(((0.3, 0.7), (-0.2, 0.2)), (0.05, 0.05), [((0.5, 0.0), (0.3, 0.3))])
    assert room[0] > FREE_GAP and (np.diff(room.round(3)) <= 0).all()
    assert abs(beside[0] - (0.5, 0.0)).max() > 0.15


@pytest.mark.parametrize("surface", [TRAY, BOWL, BIN])
def test_all_of_an_object_lies_on_a_surface_or_in_a_hollow(surface: SceneObject) -> None:
    region = region_within(surface, (0.5, 0.1), (0.05, 0.05))
    inner = surface.cavity or (surface.size[0] / 2, surface.size[1] / 2)
    for axis, middle in enumerate((0.5, 0.1)):
        assert region[axis] == pytest.approx((middle - inner[axis] + 0.025, middle + inner[axis] - 0.025))
    wide = region_within(surface, (0.5, 0.1), (0.5, 0.5))
    assert wide == ((0.5, 0.5), (0.1, 0.1))


@pytest.mark.parametrize("container", [BOWL, BIN])
def test_what_is_released_over_a_container_lies_in_it_then(container: SceneObject) -> None:
    items = tuple(map(cube, ("a", "b", "c")))
    objects = (*items, container, TABLE)
    at = (0.5, 0.2, container.size[2] / 2)
    positions = {
        "a": (0.4, -0.1, 0.025),
        "b": (0.5, -0.1, 0.025),
        "c": (0.6, -0.1, 0.025),
        container.name: at,
        "table": (0.5, 0.0, -0.02),
    }
    world = KinematicWorld(placement_error=0.0)
    world.reset(Scene(objects, positions), 0)
    for number, item in enumerate(items):
        assert takes(container, item) and not takes(item, container)
        for api, target in (("move_to", item.name), ("grasp", item.name), ("move_to", container.name)):
            assert world.call(api, (target,))
        assert above(world.truth(), "gripper", container.name)
        assert world.call("release", ())
        seen = world.truth()
        assert inside(seen, item.name, container.name)
        assert lies_in(item, seen.positions[item.name], container, at)
        assert contents(container, objects, seen.positions) == ["a", "b", "c"][: number + 1]


def test_the_next_thing_goes_where_a_container_is_empty() -> None:
    positions = {"bin": (0.5, 0.2, 0.04), "a": (0.45, 0.2, 0.03), "b": HAND}
    seen = Observation((cube("a"), cube("b"), BIN), positions, HAND, closed=True)
    x, y = place_in(seen, "bin", cube("b"))
    assert x > 0.53 and abs(y - 0.2) < 0.06
    empty = replace(seen, positions={**positions, "a": (0.3, 0.0, 0.025)})
    assert place_in(empty, "bin", cube("b")) == pytest.approx((0.5, 0.2), abs=0.011)
