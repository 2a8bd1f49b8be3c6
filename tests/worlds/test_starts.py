"""Where objects start: on what the task says, and never inside one another."""

from __future__ import annotations

from itertools import combinations
from pathlib import Path

import numpy as np
import pytest

from ntp_dsl.language.diagnostics.diagnostics import NtpError
from ntp_dsl.language.loader import diagnose_text, load
from ntp_dsl.semantics.observation import TOO_WIDE, Observation
from ntp_dsl.semantics.predicates import inside, on
from ntp_dsl.tasks.instances import draw, find_task
from ntp_dsl.worlds.protocol import Scene

LIBRARY = """
library mine
use containers

type Pad is Place
constant tray: Place

program fill(goal: list[Placement]):
    achieves all on(p.item, p.support) for p in goal
    for p in goal:
        pick_and_place(p.item, p.support)

task filling:
    scene: {scene}
    goal:    matchings(blocks, pads, pairs=1)
    run:     fill(goal)
    success: all on(p.item, p.support) for p in goal
"""
CROWDED = {
    "objects among pads": """
        pads: 3 Pad on table with box(9 cm, 9 cm, 1 cm), x(0.35 .. 0.65 m)
        blocks: 9 Block on table with box(7 cm, 5 cm, 2 cm)""",
    "two crowds in one place": """
        pads: 1 Pad on table with box(9 cm, 9 cm, 1 cm), at(80 cm, 0 cm)
        blocks: 6 Block on table with cube(7 cm), x(0.3 .. 0.6 m)
        others: 6 Block on table with cube(3 cm), x(0.35 .. 0.7 m)""",
    "a crowd with a few larger ones beside it": """
        pads: 2 Pad on table with box(9 cm, 9 cm, 1 cm), x(0.35 .. 0.65 m)
        blocks: 12 Block on table with cube(4 cm), y(-0.1 .. 0.2 m)
        others: 2 Block on table with cube(6 cm)""",
    "three parcels on a tray that has just room for them": """
        pads: 1 Pad on table with box(20 cm, 26 cm, 2 cm)
        blocks: 3 Block on pads with box(6 cm, 6 cm, 4 cm)""",
}


def starts(folder: Path, scene: str, seed: int) -> Scene:
    path = folder / "mine.ntp"
    path.write_text(LIBRARY.format(scene=scene))
    registry = load(path)
    rng = np.random.default_rng(seed)
    return draw(registry, find_task(registry, "filling"), rng).nominal_start(rng)


def test_a_tray_that_is_a_constant_carries_what_starts_on_it(tmp_path: Path) -> None:
    scene = starts(
        tmp_path,
        """
        pads: 1 Pad on tray with box(9 cm, 9 cm, 1 cm)
        blocks: 1 Block on pads with cube(4 cm)""",
        0,
    )
    seen = Observation(scene.objects, scene.positions, (0.5, 0.0, 0.5), False)
    assert on(seen, "block_0", "pad_0")
    pad, tray = scene.positions["pad_0"], scene.positions["tray"]
    assert pad[2] - 0.005 == pytest.approx(tray[2] + scene.by_name["tray"].size[2] / 2)


@pytest.mark.parametrize("size", ["35 cm, 20 cm, 1 cm", "20 cm, 35 cm, 1 cm"])
def test_a_long_tray_stands_where_it_is_told_to(tmp_path: Path, size: str) -> None:
    scene = starts(
        tmp_path,
        f"""
        pads: 1 Pad on table with box({size}), at(50 cm, 20 cm)
        blocks: 2 Block on table with y(-0.25 .. -0.05 m)""",
        0,
    )
    assert scene.positions["pad_0"] == pytest.approx((0.5, 0.2, 0.005))


def overlap(scene: Scene, a: str, b: str) -> bool:
    """Return whether two objects overlap."""
    gaps = [
        abs(scene.positions[a][axis] - scene.positions[b][axis])
        - (scene.by_name[a].size[axis] + scene.by_name[b].size[axis]) / 2
        for axis in range(3)
    ]
    return max(gaps) < -1e-9


@pytest.mark.parametrize("seed", range(10))
@pytest.mark.parametrize("crowd", CROWDED)
def test_no_two_objects_start_inside_each_other(tmp_path: Path, crowd: str, seed: int) -> None:
    scene = starts(tmp_path, CROWDED[crowd], seed)
    names = [obj.name for obj in scene.objects if obj.size[0] <= TOO_WIDE]
    assert [pair for pair in combinations(names, 2) if overlap(scene, *pair)] == []


@pytest.mark.parametrize("seed", range(10))
def test_what_starts_on_a_bin_lies_in_it(tmp_path: Path, seed: int) -> None:
    scene = starts(
        tmp_path,
        """
        pads: 2 Pad on table with bin(20 cm, 20 cm, 8 cm), y(-0.4 .. 0.4 m)
        blocks: 4 Block on pads with cube(3 cm)""",
        seed,
    )
    seen = Observation(scene.objects, scene.positions, (0.5, 0.0, 0.5), False)
    for block in (f"block_{number}" for number in range(4)):
        assert sum(inside(seen, block, pad) for pad in ("pad_0", "pad_1")) == 1
        bottom = scene.positions[block][2] - scene.by_name[block].size[2] / 2
        assert bottom < 0.01, "on the floor of the bin, not on its rim"


def test_what_starts_on_others_is_on_them(tmp_path: Path) -> None:
    scene = starts(
        tmp_path,
        """
        pads: 2 Pad on table with box(9 cm, 9 cm, 1 cm)
        blocks: 2 Block on pads
        others: 2 Block on blocks with cube(4 cm)""",
        0,
    )
    seen = Observation(scene.objects, scene.positions, (0.5, 0.0, 0.5), False)
    lower, upper = ("block_0", "block_1"), ("block_2", "block_3")
    assert all(any(on(seen, block, pad) for pad in ("pad_0", "pad_1")) for block in lower)
    assert all(any(on(seen, other, block) for block in lower) for other in upper)


@pytest.mark.parametrize("seed", range(5))
def test_parts_stand_on_a_fixed_object_where_their_offsets_say(tmp_path: Path, seed: int) -> None:
    path = tmp_path / "mine.ntp"
    scene = """
        boards: 1 Pad on table with box(30 cm, 20 cm, 4 cm)
        pads:   2 Pad on boards with box(8 cm, 8 cm, 1 cm), offset(-9 cm, 0 cm, 9 cm, 3 cm)
        blocks: 2 Block on pads"""
    path.write_text(LIBRARY.replace("{scene}", scene))
    registry = load(path)
    rng = np.random.default_rng(seed)
    task = draw(registry, find_task(registry, "filling"), rng)
    for made in (task.nominal_start(rng), task.perturbed_start(rng)):
        x, y, z = made.positions["pad_0"]
        assert np.allclose(made.positions["pad_1"], (x - 0.09, y, z + 0.025))
        assert np.allclose(made.positions["pad_2"], (x + 0.09, y + 0.03, z + 0.025))


def test_an_offset_from_the_table_is_explained() -> None:
    scene = "pads: 1 Pad on table with offset(3 cm, 3 cm)"
    found = diagnose_text(LIBRARY.replace("{scene}", scene)).diagnostics
    assert any("an offset is from the middle of an object of the scene" in each.message for each in found)


@pytest.mark.parametrize("turn", [0, 30, 90])
def test_parts_are_turned_with_what_they_are_parts_of(tmp_path: Path, turn: int) -> None:
    path = tmp_path / "mine.ntp"
    scene = f"""
        boards: 1 Pad on table with box(24 cm, 11 cm, 2 cm), at(50 cm, 0 cm), yaw({turn} deg)
        pads:   2 Pad on boards with box(4 cm, 4 cm, 1 cm), offset(-9 cm, 0 cm, 9 cm, 0 cm)
        blocks: 1 Block on table"""
    path.write_text(LIBRARY.replace("{scene}", scene))
    registry = load(path)
    rng = np.random.default_rng(0)
    made = draw(registry, find_task(registry, "filling"), rng).nominal_start(rng)
    angle = np.radians(turn)
    way = np.array([np.cos(angle), np.sin(angle)]) * 0.09
    assert np.allclose(made.positions["pad_2"][:2], np.array([0.5, 0.0]) + way)
    assert np.allclose(made.positions["pad_1"][:2], np.array([0.5, 0.0]) - way)


def test_a_part_beyond_the_edge_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "mine.ntp"
    scene = """
        boards: 1 Pad on table with box(24 cm, 11 cm, 2 cm)
        pads:   1 Pad on boards with box(4 cm, 4 cm, 1 cm), offset(30 cm, 0 cm)
        blocks: 1 Block on table"""
    path.write_text(LIBRARY.replace("{scene}", scene))
    registry = load(path)
    rng = np.random.default_rng(0)
    with pytest.raises(NtpError, match="beyond the edge of pad_0"):
        draw(registry, find_task(registry, "filling"), rng).nominal_start(rng)
