"""Facts of the state that change while the hand stays as it is: which call changed them is read rightly."""

from __future__ import annotations

import pytest
from one_core_samples import lists, read

from ntp_dsl.api import demonstrate, draw
from ntp_dsl.evaluation.demonstration_remarks import act
from ntp_dsl.libraries import load_text

SCALES = """library scales
use tabletop
type Bay is Place
enum Way: straight, weighed
record Move(box: Block, bay: Bay, way: Way)
predicate measured(b: Block) by state
predicate went(b: Block, way: Way):
    way == straight or measured(b)
api weigh(b: Block)
    requires holding(b)
    achieves measured(b)
program put_on_scales(b: Block):
    requires present(b) and reachable(b)
    achieves measured(b)
    pick(b)
    weigh(b)
program bring(b: Block, bay: Bay, way: Way):
    requires present(b) and reachable(b) and present(bay) and reachable(bay)
    achieves on(b, bay) and went(b, way)
    when way == weighed: put_on_scales(b)
    pick_and_place(b, bay)
program bring_all(moves: list[Move]):
    achieves all on(m.box, m.bay) and went(m.box, m.way) for m in moves
    for m in moves: bring(m.box, m.bay, m.way)
task scales:
    scene:
        bays: 3 Bay on table with box(8 cm, 8 cm, 1 cm)
        blocks: 3 Block on table
    goal: (block_0, bay_0, weighed)
    run: bring_all(goal)
    success: on(block_0, bay_0) and measured(block_0)
"""
LOCKS = """library locks
use tabletop
type Parcel is Movable
type Cage is Place
record Order(parcel: Parcel, cage: Cage)
predicate stamped(p: Parcel) by state
predicate locked(c: Cage) by state
api stamp(p: Parcel)
    requires above(gripper, p) and empty(gripper) and clear(p)
    achieves stamped(p)
api lock(c: Cage)
    requires above(gripper, c) and empty(gripper)
    achieves locked(c)
program send(orders: list[Order]):
    achieves (
        (all stamped(o.parcel) and on(o.parcel, o.cage) for o in orders)
        and all locked(o.cage) for o in orders
    )
    for o in orders: mark(o.parcel)
    for o in orders: pick_and_place(o.parcel, o.cage)
    for o in orders: shut(o.parcel, o.cage)
program mark(p: Parcel):
    requires present(p) and reachable(p)
    achieves stamped(p)
    put_down()
    clear(p)
    move_to(p)
    stamp(p)
program shut(p: Parcel, c: Cage):
    requires present(c) and reachable(c) and on(p, c)
    achieves locked(c)
    put_down()
    move_to(c)
    lock(c)
task locks:
    scene:
        cages: 3 Cage on table with box(26 cm, 20 cm, 1 cm), at(36 cm, 28 cm, 64 cm, 28 cm, 45 cm, -28 cm)
        parcels: 6 Parcel on table with cylinder(5 cm, 4 cm), y(-0.14 .. 0.14 m)
    goal: matchings(parcels, cages, pairs=2..4) -> list[Order]
    run: send(goal)
    success: all stamped(o.parcel) and on(o.parcel, o.cage) and locked(o.cage) for o in goal
"""
CASES = {"of what is in the hand": (SCALES, 20), "of several elements at once": (LOCKS, 24)}


@pytest.mark.parametrize("case", CASES)
def test_a_change_is_the_act_of_a_call_that_changes_the_state(case: str, soak: bool) -> None:
    text, count = CASES[case]
    registry = load_text(text)
    for seed in range(100 if soak else count):
        task = draw(registry, registry.name, seed)
        found = read(task, demonstrate(task).demonstration)
        assert lists(found.arguments) == lists(task.instance.arguments), seed
        assert found.explained == found.acts > 0


def test_a_change_that_no_call_makes_is_not_explained() -> None:
    told = load_text(SCALES)
    without = load_text(SCALES.replace("    when way == weighed: put_on_scales(b)\n", ""))
    for seed in range(8):
        shown = demonstrate(draw(told, "scales", seed)).demonstration
        found = read(draw(without, "scales", seed), shown)
        assert found.explained == found.acts - 1
        (missed,) = found.unexplained
        assert act(shown, missed).startswith("measured(block_0) comes true, at ")
