"""A library with as much as possible in Python: objects in a row, at the distances of the goal."""

from __future__ import annotations

from pathlib import Path

LIBRARY = """
library row
use tabletop

type Mark is Place
type Cell is Place
record Link(item: Movable, after: Place, gap: length)

predicate beside(item: Movable, after: Place, gap: length) by python
predicate in_the_way(o: Movable, after: Place, gap: length) by python
predicate room(item: Movable, after: Place, gap: length):
    not some in_the_way(o, after, gap) for o in Movable if o != item

api set_down(item: Movable, after: Place, gap: length in 8 cm .. 14 cm) by python
    requires holding(item) and room(item, after, gap) and present(after)
    achieves beside(item, after, gap)

program make_room(item: Movable, after: Place, gap: length):
    achieves room(item, after, gap)
    for o in Movable if in_the_way(o, after, gap) and o != item:
        for c in Cell if clear(c):
            pick_and_place(o, c)

program append(item: Movable, after: Place, gap: length):
    requires present(item) and reachable(item) and present(after)
    achieves beside(item, after, gap)
    make_room(item, after, gap)
    pick(item)
    set_down(item, after, gap)

program line_up(goal: list[Link]) by python:
    achieves all beside(l.item, l.after, l.gap) for l in goal
    calls append

task in_a_row:
    scene:
        marks: 1 Mark on table with box(5 cm, 5 cm, 0.5 cm), at(40 cm, -30 cm)
        cells: 3 Cell on table with box(8 cm, 8 cm, 1 cm), at(72 cm, -40 cm, 72 cm, -10 cm, 72 cm, 20 cm)
        blocks: 4 Block on table
    goal:    rows(marks, blocks, length=2..3) -> list[Link] by python
    run:     line_up(goal)
    success: all beside(l.item, l.after, l.gap) for l in goal
"""
PYTHON = """
from ntp_dsl.authoring import call, expert, predicate, sampler, skill


def spot(observation, after, gap):
    x, y = observation.positions[after][:2]
    return x, y + gap


def distance(observation, o, after, gap):
    x, y = spot(observation, after, gap)
    p = observation.positions[o]
    return max(abs(p[0] - x), abs(p[1] - y))


@predicate
def beside(observation, item, after, gap):
    if not {item, after} <= set(observation.positions) or observation.held == item:
        return False
    low = observation.positions[item][2] - observation.by_name[item].size[2] / 2 < 0.02
    return low and distance(observation, item, after, gap) < 0.012


@predicate
def in_the_way(observation, o, after, gap):
    if o == after or not {o, after} <= set(observation.positions) or observation.held == o:
        return False
    return distance(observation, o, after, gap) < 0.07


@skill
def set_down(world, item, after, gap):
    if not (over := world.move_over(*spot(world.observe(), after, gap))):
        return over
    return world.call("release", ())


@expert
def line_up(world, goal):
    links = [(link["item"], link["after"], link["gap"]) for link in goal]
    return [call("append", *link) for link in links if not world.beside(*link)]


@sampler
def rows(rng, marks, blocks, length, topology, semantics):
    items = semantics.permutation(blocks)[:length]
    gaps = topology.choice([0.09, 0.11, 0.13], len(items))
    return list(zip(items, [marks[0], *items], gaps, strict=False))
"""


def written(folder: Path, old: str = "", new: str = "") -> Path:
    """Write the library, with a replacement in its text or its Python."""
    assert old in LIBRARY or old in PYTHON
    path = folder / "row.ntp"
    path.write_text(LIBRARY.replace(old, new) if old else LIBRARY)
    path.with_suffix(".py").write_text(PYTHON.replace(old, new) if old else PYTHON)
    return path
