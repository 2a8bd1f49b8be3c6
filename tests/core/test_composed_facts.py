"""A fact with a body counts as what it says: the expert and the core serve it, whatever the words."""

from __future__ import annotations

import json
from itertools import product
from pathlib import Path

import pytest

from ntp_dsl.cli.app import run

BUILT = """library building
use tabletop
type Pad is Place
predicate done(p: Pad) by state
predicate tower(a: Block, b: Block, p: Pad): on(a, p) and on(b, a)
predicate built(a: Block, b: Block, p: Pad): tower(a, b, p) and done(p)
api stamp(p: Pad)
    requires above(gripper, p) and empty(gripper)
    achieves done(p)
program stack(a: Block, b: Block, p: Pad):
    requires present(a) and reachable(a) and present(b) and reachable(b) and present(p) and reachable(p)
    achieves {stacked}
    pick_and_place(a, p)
    pick_and_place(b, a)
program mark(a: Block, b: Block, p: Pad):
    requires {needed} and present(p) and reachable(p)
    achieves done(p)
    put_down()
    move_to(p)
    stamp(p)
program build(a: Block, b: Block, p: Pad):
    requires present(a) and reachable(a) and present(b) and reachable(b) and present(p) and reachable(p)
    achieves {wanted}
    stack(a, b, p)
    mark(a, b, p)
task building:
    scene:
        pad: Pad on table with box(8 cm, 8 cm, 1 cm)
        red: Block on table
        blue: Block on table
    initially: done(pad)
    run: build(red, blue, pad)
    success: built(red, blue, pad)
"""
NAMED, SPELT = "tower(a, b, p)", "on(a, p) and on(b, a)"
WANTED = ["built(a, b, p)", f"{NAMED} and done(p)", f"{SPELT} and done(p)"]

EITHER = """library either
use tabletop
type Bay is Place
enum Way: straight, weighed
record Move(box: Block, bay: Bay, way: Way)
predicate measured(b: Block) by state
predicate went(b: Block, way: Way): way == straight or measured(b)
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
    achieves on(b, bay) and {of_one}
    when way == weighed: put_on_scales(b)
    pick_and_place(b, bay)
program bring_all(moves: list[Move]):
    achieves all on(m.box, m.bay) and {of_each} for m in moves
    for m in moves: bring(m.box, m.bay, m.way)
task either:
    scene:
        bays: 3 Bay on table with box(8 cm, 8 cm, 1 cm)
        blocks: 3 Block on table
    goal: (block_0, bay_0, weighed), (block_2, bay_1, straight)
    run: bring_all(goal)
    success: on(block_0, bay_0) and measured(block_0) and on(block_2, bay_1)
"""
OF_ONE = ["went(b, way)", "(way == straight or measured(b))"]
OF_EACH = ["went(m.box, m.way)", "(m.way == straight or measured(m.box))"]


def succeeds(folder: Path, text: str, capsys: pytest.CaptureFixture[str]) -> bool:
    """Return whether checks pass, and the expert and the core both succeed in every episode."""
    path = folder / f"{text.split()[1]}.ntp"
    path.write_text(text, encoding="utf-8")
    assert run(["check", str(path)]) == 0, capsys.readouterr().out
    capsys.readouterr()
    rates = []
    for words in (["--expert"], []):
        assert run(["eval", str(path), path.stem, "-n", "3", "--json", *words]) == 0
        rates.append(json.loads(capsys.readouterr().out)["success"])
    return rates == [1.0, 1.0]


@pytest.mark.parametrize(("wanted", "stacked", "needed"), [*product(WANTED, [NAMED, SPELT], [NAMED, SPELT])])
def test_a_tower_is_built_in_whatever_words_it_is_asked_for(
    tmp_path: Path, wanted: str, stacked: str, needed: str, capsys: pytest.CaptureFixture[str]
) -> None:
    text = BUILT.format(wanted=wanted, stacked=stacked, needed=needed)
    assert succeeds(tmp_path, text, capsys)


@pytest.mark.parametrize(("of_one", "of_each"), [*product(OF_ONE, OF_EACH)])
def test_one_of_two_is_served_in_whatever_words_it_is_asked_for(
    tmp_path: Path, of_one: str, of_each: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert succeeds(tmp_path, EITHER.format(of_one=of_one, of_each=of_each), capsys)
