"""Deadlocks and refused calls of an expert are distinguished from livelocks."""

from __future__ import annotations

from pathlib import Path
from re import search

from checked_libraries import ALL_ON, BRINGING, PLACING, STACKING, diagnostics, excerpt, written

SWAPPING = """
type Plate is Place
type Spare is Place
type Weight is Movable

program exchange(goal: list[Placement]):
    achieves all on(p.item, p.support) for p in goal
    for p in goal:
        bring(p.item, p.support)

program bring(item: Movable, plate: Place):
    requires present(item) and reachable(item) and present(plate) and reachable(plate)
    achieves on(item, plate)
    vacate(plate, item)
    pick_and_place(item, plate)

program vacate(plate: Place, item: Movable):
    requires present(plate) and reachable(plate)
    achieves not some on(b, plate) for b in Block if b != item
    for b in Block if on(b, plate) and b != item:
        for s in Spare if clear(s):
            pick_and_place(b, s)

task exchanging:
    scene:
        plates: 3 Plate on table with box(10 cm, 10 cm, 1 cm), x(0.35 .. 0.65 m)
        spares: 1 Spare on table with box(10 cm, 10 cm, 1 cm)
        weights: 1 Weight on spares
        blocks: 3 Block on plates
    goal:    permutations(blocks, plates)
    run:     exchange(goal)
    success: all on(p.item, p.support) for p in goal
"""
OVERFULL = (
    """
type Pad is Place
"""
    + PLACING
    + """
task filling:
    scene:
        pads: 1 Pad on table with box(30 cm, 26 cm, 1 cm), at(52 cm, 20 cm)
        blocks: 2 Block on table with box(11 cm, 11 cm, 5 cm), y(-0.25 .. 0 m)
    goal:    matchings(blocks, pads, pairs=2)
    run:     fill(goal)
    success: all on(p.item, p.support) for p in goal
"""
)


def test_a_program_that_repeatedly_ends_unfinished_is_a_deadlock_with_its_reason(tmp_path: Path) -> None:
    (livelock,) = [each for each in diagnostics(written(tmp_path, SWAPPING)) if each.code == "E605"]
    reason = r"has not achieved not on\(block_., plate_.\), but no statement is due"
    assert livelock.message.startswith("'exchanging' is in a deadlock") and search(reason, livelock.message)
    state, note = livelock.notes
    assert search(r"block_. on plate_.*; nothing in the hand$", state.message)
    assert (
        note.message == "skipped: no element meets the conditions of the loop: clear(spare_0) does not hold"
    )
    assert "undoes" not in livelock.help and "'vacate'" in livelock.help


HALF_WAY = (
    BRINGING
    + """    lift(item, support)

program lift(item: Movable, support: Place):
    requires present(item) and reachable(item)
    achieves on(item, support)
    pick(item)
"""
)


def test_in_a_deadlock_the_statements_that_already_hold_are_named(tmp_path: Path) -> None:
    tower = STACKING.replace("placements=1..2", "placements=1").format(run="fill(goal)", success=ALL_ON)
    path = written(tmp_path, HALF_WAY + tower)
    stuck = next(each for each in diagnostics(path) if each.code == "E605")
    assert stuck.message.startswith("'tower' is in a deadlock")
    assert "has not achieved on(block_" in stuck.message and "no statement is due" in stuck.message
    _, note = stuck.notes
    assert search(r"^skipped: what it achieves already holds: holding\(block_.\)$", note.message)
    assert path.read_text().split("\n")[note.span.line - 1].strip() == "pick(item)"


def test_an_expert_whose_calls_are_refused_is_not_reported_as_a_livelock(tmp_path: Path) -> None:
    path = written(tmp_path, OVERFULL)
    found = diagnostics(path)
    assert [each.code for each in found if each.severity == "error"] == []
    (stuck,) = [each for each in found if each.code == "W603"]
    assert "the world refuses move_to(pad_0): no path" in stuck.message
    assert excerpt(path, stuck).startswith("pads: 1 Pad on table")
