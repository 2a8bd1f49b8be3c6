"""What nothing explains: it is said, and where there is noise it may lie a little beside where it is seen."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from one_core_samples import lists, read, shown

from ntp_dsl.demonstrations.demonstration import Demonstration

ASIDE = 0.019  # more than a placement may be off [m]


def with_the_last_aside(demonstration: Demonstration, deviation: float) -> tuple[str, Demonstration]:
    """Return the object that is put down last, and a demonstration in which it is seen to lie aside."""
    frame = int(np.flatnonzero(np.diff(demonstration.closed.astype(int)))[-1]) + 1
    moved = np.abs(np.diff(demonstration.positions[frame - 8 : frame], axis=0)).sum(axis=(0, 2))
    index = int(moved.argmax())
    positions = demonstration.positions.copy()
    positions[frame:, index, 0] += ASIDE
    shape = positions.shape[:2]
    return demonstration.names[index], replace(
        demonstration,
        positions=positions,
        deviations=np.full(shape, deviation, dtype=np.float32) if deviation else None,
    )


@pytest.mark.parametrize("name", ["block_stacking", "seating", "exchange"])
def test_what_is_put_somewhere_for_no_reason_is_said(name: str) -> None:
    task, demonstration = shown(name, 3)
    item, seen = with_the_last_aside(demonstration, 0.0)
    found = read(task, seen)
    assert [each.item for each in found.strays] == [item]
    assert found.explained < found.acts
    assert found.probability <= 0.1


@pytest.mark.parametrize("name", ["block_stacking", "seating", "exchange"])
def test_what_noise_moves_aside_is_read_where_it_belongs(name: str) -> None:
    task, demonstration = shown(name, 3)
    _, seen = with_the_last_aside(demonstration, 0.02)
    found = read(task, seen)
    assert found.is_whole and not found.strays
    assert lists(found.arguments) == lists(task.instance.arguments)


def test_of_what_is_shown_well_nothing_is_astray() -> None:
    for name in ("block_stacking", "table_cleanup", "kitting"):
        found = read(*shown(name, 3))
        assert not found.strays and found.probability == 1
