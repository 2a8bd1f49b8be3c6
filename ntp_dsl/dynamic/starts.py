"""The starts that experts are tried from: nominal and perturbed ones."""

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

PILE = 5  # objects in a pile, about
HAND_HEIGHT = 0.3  # of an object that is in the hand at the start [m]

Start = Callable[[Instance, np.random.Generator], Scene]


def nominal(instance: Instance, rng: np.random.Generator) -> Scene:
    """Return a start with all objects apart, as demonstrations begin."""
    return instance.nominal_start(rng)


def perturbed(instance: Instance, rng: np.random.Generator) -> Scene:
    """Return a start with partial and wrong towers and, at random, an object in the hand."""
    return instance.perturbed_start(rng, straight=1.0)


def leaning(instance: Instance, rng: np.random.Generator) -> Scene:
    """Return a perturbed start in which no object is centred on its support, as after slips."""
    return instance.perturbed_start(rng, straight=0.0)


def wrong_in_hand(instance: Instance, rng: np.random.Generator) -> Scene:
    """Return a start with an object in the hand that no program asked for."""
    scene = instance.nominal_start(rng)
    items = [obj.name for obj in movable(scene.objects)]
    held = str(rng.choice(items))
    hand: Vector = (0.5, 0.0, HAND_HEIGHT)
    place = in_hand_at(scene.by_name[held], hand)
    return replace(scene, positions={**scene.positions, held: place}, gripper=hand, held=held)


def buried(instance: Instance, rng: np.random.Generator) -> Scene:
    """Return a few piles, so that most of the needed objects are covered."""
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


def lost(instance: Instance, rng: np.random.Generator) -> Scene:
    """Return a start that lacks an object without a load: the expert may fail, but must end."""
    scene = instance.perturbed_start(rng, in_hand=False, straight=1.0)
    solid = [obj.name for obj in movable(scene.objects) if obj.cavity is None]
    order = rng.permutation(solid or [obj.name for obj in movable(scene.objects)])
    missing = str(max(order, key=lambda name: scene.positions[name][2]))
    positions = {name: place for name, place in scene.positions.items() if name != missing}
    return replace(scene, positions=positions)


def told(seen: Observation) -> str:
    """Describe which objects are on, in or under others or in the hand; the rest stand by themselves."""
    said = []
    for obj in seen.by_name.values():
        if not obj.movable:
            continue
        if obj.name not in seen.positions:
            said.append(f"{obj.name} is lost")
        elif obj.name == seen.held:
            said.append(f"{obj.name} in the hand")
        else:
            said += _below(seen, obj.name)[:1]
    return ", ".join(said) or "everything by itself"


def _below(seen: Observation, item: str) -> list[str]:
    others = [other.name for other in seen.objects if other.name != item and other.size[0] <= TOO_WIDE]
    lies_in = [f"{item} in {other}" for other in others if inside(seen, item, other)]
    return lies_in or [f"{item} on {other}" for other in others if on(seen, item, other)]


def whereabouts(seen: Observation, names: Iterable[object]) -> str:
    """Describe the positions of objects [m]."""
    known = [name for name in dict.fromkeys(names) if isinstance(name, str) and name in seen.positions]
    places = (", ".join(f"{value:.3f}" for value in seen.positions[name]) for name in known)
    return "; ".join(f"{name} at ({place}) m" for name, place in zip(known, places, strict=True))


STARTS: Mapping[str, tuple[Start, int]] = {  # kind -> how to make one, and how many are tried
    "nominal": (nominal, 6),
    "perturbed": (perturbed, 10),
    "leaning": (leaning, 6),
    "wrong in hand": (wrong_in_hand, 4),
    "buried": (buried, 6),
    "lost": (lost, 4),
}
