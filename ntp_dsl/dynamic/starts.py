"""Initial states for testing experts, nominal and perturbed."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace

import numpy as np

from ntp_dsl.semantics.geometry import Vector
from ntp_dsl.semantics.observation import TOO_WIDE, Observation
from ntp_dsl.semantics.predicates import inside, on
from ntp_dsl.tasks.instances import Instance
from ntp_dsl.worlds.protocol import Scene
from ntp_dsl.worlds.scenes import movable
from ntp_dsl.worlds.starts import in_hand_at

PILE = 5  # approximate number of objects in a pile
HAND_HEIGHT = 0.3  # of the hand where it holds an object at the start [m]

Start = Callable[[Instance, np.random.Generator], Scene]


def nominal(instance: Instance, rng: np.random.Generator) -> Scene:
    """Return a start of demonstrations: all objects apart from each other."""
    return instance.nominal_start(rng)


def perturbed(instance: Instance, rng: np.random.Generator) -> Scene:
    """Return a start with partial and wrong towers, and sometimes an object in the hand."""
    return instance.perturbed_start(rng, straight=1.0)


def off_centre(instance: Instance, rng: np.random.Generator) -> Scene:
    """Return a perturbed start in which no object is centred on the one below, as after a slip."""
    return instance.perturbed_start(rng, straight=0.0)


def object_in_hand(instance: Instance, rng: np.random.Generator) -> Scene:
    """Return a start with an arbitrary object in the hand."""
    scene = instance.nominal_start(rng)
    items = [obj.name for obj in movable(scene.objects)]
    held = str(rng.choice(items))
    hand: Vector = (0.5, 0.0, HAND_HEIGHT)
    place = in_hand_at(scene.by_name[held], hand)
    return replace(scene, positions={**scene.positions, held: place}, gripper=hand, held=held)


def piles(instance: Instance, rng: np.random.Generator) -> Scene:
    """Return a start of a few piles, in which most objects have another on top."""
    scene = instance.nominal_start(rng)
    items = movable(scene.objects)
    order = [items[index] for index in rng.permutation(len(items))]
    positions = dict(scene.positions)
    tops = order[: max(2, len(order) // PILE)]
    for number, item in enumerate(order[len(tops) :]):
        below = tops[number % len(tops)]
        x, y, z = positions[below.name]
        positions[item.name] = (x, y, z + (below.size[2] + item.size[2]) / 2)
        tops[number % len(tops)] = item
    return replace(scene, positions=positions)


def missing_object(instance: Instance, rng: np.random.Generator) -> Scene:
    """Return a start without one of the top objects: the expert may fail, but must end."""
    scene = instance.perturbed_start(rng, in_hand=False, straight=1.0)
    solid = [obj.name for obj in movable(scene.objects) if obj.cavity is None]
    order = rng.permutation(solid or [obj.name for obj in movable(scene.objects)])
    name = str(max(order, key=lambda each: scene.positions[each][2]))
    positions = {each: place for each, place in scene.positions.items() if each != name}
    return replace(scene, positions=positions)


def scene_text(seen: Observation) -> str:
    """Return what is on what, and what is in the hand; objects that are not named stand alone."""
    parts = []
    for obj in seen.by_name.values():
        if not obj.movable:
            continue
        if obj.name not in seen.positions:
            parts.append(f"{obj.name} missing")
        elif obj.name == seen.held:
            parts.append(f"{obj.name} in the hand")
        else:
            parts += _below(seen, obj.name)[:1]
    return ", ".join(parts) or "all objects apart"


def _below(seen: Observation, item: str) -> list[str]:
    others = [other.name for other in seen.objects if other.name != item and other.size[0] <= TOO_WIDE]
    lies_in = [f"{item} in {other}" for other in others if inside(seen, item, other)]
    return lies_in or [f"{item} on {other}" for other in others if on(seen, item, other)]


def positions_text(seen: Observation, names: Iterable[object]) -> str:
    """Return the positions of objects as text [m]."""
    known = [name for name in dict.fromkeys(names) if isinstance(name, str) and name in seen.positions]
    places = (", ".join(f"{value:.3f}" for value in seen.positions[name]) for name in known)
    return "; ".join(f"{name} at ({place}) m" for name, place in zip(known, places, strict=True))


STARTS: Mapping[str, tuple[Start, int]] = {  # kind -> function, and number of trials
    "nominal": (nominal, 6),
    "perturbed": (perturbed, 10),
    "off-centre": (off_centre, 6),
    "object in hand": (object_in_hand, 4),
    "piles": (piles, 6),
    "missing object": (missing_object, 4),
}
