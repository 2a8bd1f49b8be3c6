"""Objects that a library moves out of the way may move; any other object that moves is a failure."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from ntp_dsl.evaluation.success import judge
from ntp_dsl.execution.interpreter import Interpreter
from ntp_dsl.language.loader import load
from ntp_dsl.policies.expert import Expert
from ntp_dsl.policies.scripted import ScriptedPolicy
from ntp_dsl.tasks.instances import draw, find_task
from ntp_dsl.worlds.catalogue import make_world

LIBRARY = """
library mine
use tabletop

type Tray is Place
type Cup is Movable

program serve(goal: list[Placement]):
    achieves all on(p.item, p.support) for p in goal
    for p in goal:
        make_room(p.support)
    for p in goal:
        pick_and_place(p.item, p.support)

program make_room(tray: Place):
    achieves all not on(b, tray) for b in Block
    for b in Block if on(b, tray):
        pick(b)

task serving:
    scene:
        trays:  1 Tray on table with box(20 cm, 20 cm, 1 cm), at(50 cm, 34 cm)
        blocks: 1 Block on trays
        others: 1 Block on table with x(0.35 .. 0.4 m)
        cups:   1 Cup on table with cylinder(5 cm, 6 cm), x(0.55 .. 0.6 m)
    goal:    matchings(cups, trays, pairs=1)
    run:     serve(goal)
    success: all on(p.item, p.support) for p in goal
"""


def verdict(folder: Path, moved_first: str | None) -> str:
    """Return the verdict on the expert's run, after something was first moved elsewhere."""
    path = folder / "mine.ntp"
    path.write_text(LIBRARY)
    registry = load(path)
    rng = np.random.default_rng(0)
    instance = draw(registry, find_task(registry, "serving"), rng)
    scene = instance.nominal_start(rng)
    world = make_world("kinematic", registry)
    world.reset(scene, 0)
    if moved_first is not None:
        assert world.call("move_to", (moved_first,)).achieved
        assert world.call("grasp", (moved_first,)).achieved
        assert world.move_over(0.45, -0.05).achieved and world.call("release", ()).achieved
    interpreter = Interpreter(registry, ScriptedPolicy(Expert(registry)), world)
    run = interpreter.run(instance.program, instance.arguments)
    run.handled |= {moved_first or ""}
    return judge(registry, world, instance, scene, run).reason


def test_objects_in_the_way_may_be_moved(tmp_path: Path) -> None:
    assert verdict(tmp_path, None) == ""


@pytest.mark.parametrize(("moved_first", "reason"), [("block_0", ""), ("block_1", "block_1 was moved")])
def test_other_objects_may_not(tmp_path: Path, moved_first: str, reason: str) -> None:
    assert verdict(tmp_path, moved_first) == reason
