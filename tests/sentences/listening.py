"""Scenes to talk about, and what is understood of them."""

from __future__ import annotations

from functools import cache

from ntp_dsl.evaluation.episode_parts import drawn_instance
from ntp_dsl.evaluation.listening import as_lists, listener
from ntp_dsl.language.registry import Registry
from ntp_dsl.libraries import load, load_text
from ntp_dsl.sentences.understanding import Listener
from ntp_dsl.tasks.instances import Instance

COLOURED = '''
library coloured
use tabletop
enum Colour: red, green, blue
type Cup is Movable
type Tray is Place
record Move(cup: Cup, tray: Tray)
predicate colour(cup: Cup) -> Colour
program tidy(moves: list[Move]):
    """Bring cups to trays."""
    achieves all on(m.cup, m.tray) for m in moves
    for m in moves:
        pick_and_place(m.cup, m.tray)
task tidy:
    scene:
        trays:  2 Tray on table with box(20 cm, 20 cm, 1 cm)
        reds:   1 Cup on table with colour(red), cylinder(5 cm, 6 cm)
        greens: 1 Cup on table with colour(green), cylinder(4 cm, 4 cm)
        blues:  2 Cup on table with colour(blue), cylinder(4 cm, 4 cm)
    goal:    permutations(reds, trays) -> list[Move]
    run:     tidy(goal)
    success: all on(m.cup, m.tray) for m in goal
'''


WASHING = """
library washing
use tabletop
enum Colour: red, green
type Cup is Movable
predicate colour(cup: Cup) -> Colour
predicate washed(cup: Cup) by state
predicate dried(cup: Cup) by state
api wash(cup: Cup)
    requires holding(cup)
    achieves washed(cup)
api dry(cup: Cup)
    requires holding(cup)
    achieves dried(cup)
program clean(cup: Cup):
    requires present(cup) and reachable(cup)
    achieves washed(cup)
    pick(cup)
    wash(cup)
program warm(cup: Cup):
    requires present(cup) and reachable(cup)
    achieves dried(cup)
    pick(cup)
    dry(cup)
program tidy(dirty: list[Cup], wet: list[Cup]):
    achieves (all washed(c) for c in dirty) and (all dried(c) for c in wet)
    for c in dirty: clean(c)
    for c in wet: warm(c)
task washing:
    scene:
        reds:   1 Cup on table with colour(red), cylinder(5 cm, 6 cm)
        greens: 2 Cup on table with colour(green), cylinder(4 cm, 4 cm)
    run:     tidy(reds, greens)
    success: (all washed(c) for c in reds) and (all dried(c) for c in greens)
"""
TEXTS = {"coloured": COLOURED, "washing": WASHING}


@cache
def example(name: str) -> Registry:
    return load_text(TEXTS[name]) if name in TEXTS else load(name)


def scene(name: str, seed: int = 0, task: str = "") -> tuple[Listener, Instance]:
    """Return who listens in a scene of an example, and its task."""
    registry = example(name)
    return in_scene(registry, task or next(iter(registry.tasks)), seed)


def in_scene(registry: Registry, task: str, seed: int = 0) -> tuple[Listener, Instance]:
    drawn = drawn_instance(registry, registry.tasks[task], seed, 0)
    return listener(registry, drawn, seed, 0), drawn


def lists(who: Listener, *sentences: str) -> list[str]:
    """Return the elements that sentences say, as text, in their order."""
    found = who.understand(sentences)
    named = as_lists(who.registry, who.program.name, found.arguments)
    return [str(element) for elements in named.values() for element in elements]
