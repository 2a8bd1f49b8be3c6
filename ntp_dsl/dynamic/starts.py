"""Initial states for testing experts, nominal and perturbed."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace

import numpy as np

from ntp_dsl.semantics.observation import TOO_WIDE, Observation
from ntp_dsl.semantics.predicates import covers, inside, on
from ntp_dsl.tasks.instances import Instance
from ntp_dsl.worlds.perturbed_starts import piled_start, with_in_hand
from ntp_dsl.worlds.protocol import Scene
from ntp_dsl.worlds.scenes import movable
from ntp_dsl.worlds.standing import Standing

PILE = 5  # approximate number of objects in a pile
MOST = 6  # objects that a text places
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
    loaded = _loaded(scene)
    free = [obj.name for obj in movable(scene.objects) if obj.name not in loaded]
    if not free:
        return scene
    return with_in_hand(scene, str(rng.choice(free)), (0.5, 0.0, HAND_HEIGHT))


def piles(instance: Instance, rng: np.random.Generator) -> Scene:
    """Return a start of a few piles, in which most objects have another on top."""
    count = max(2, len(movable(instance.objects)) // PILE)
    return instance.in_state(piled_start(instance.objects, rng, count, instance.starts))


def missing_object(instance: Instance, rng: np.random.Generator) -> Scene:
    """Return a start without one of the top objects: the expert may fail, but must end."""
    scene = instance.perturbed_start(rng, in_hand=False, straight=1.0)
    loaded = _loaded(scene)
    free = [obj for obj in movable(scene.objects) if obj.name not in loaded]
    if not free:
        return scene
    order = rng.permutation([obj.name for obj in free if obj.cavity is None] or [obj.name for obj in free])
    name = str(max(order, key=lambda each: scene.positions[each][2]))
    positions = {each: place for each, place in scene.positions.items() if each != name}
    return replace(scene, positions=positions)


def _loaded(scene: Scene) -> set[str]:
    """Return the objects that others are on or in."""
    return Standing(scene.by_name, dict(scene.positions)).carriers()


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
            parts += [f"{obj.name} {how} {other}" for how, other in _below(seen, obj.name)[:1]]
    more = [f"and {len(parts) - MOST} more"] if len(parts) > MOST else []
    return ", ".join([*parts[:MOST], *more]) or "all objects apart"


def state_text(seen: Observation, names: Iterable[str]) -> str:
    """Return in a few words where some objects are, what is on or in them, and what the hand holds."""
    named = [name for name in dict.fromkeys(names) if name in seen.by_name]
    below = {
        obj.name: _below(seen, obj.name) for obj in seen.objects if obj.movable and obj.name != seen.held
    }
    near = [item for item, rows in below.items() if any(other in named for _, other in rows)]
    placed = [_place(seen, name, below.get(name)) for name in dict.fromkeys([*named, *near])]
    hand = f"{seen.held} in the hand" if seen.held else "nothing in the hand"
    parts = [*filter(None, placed), *seen.facts_about(named)]
    more = f"and {len(parts) - MOST} more; " if len(parts) > MOST else ""
    return "; ".join([", ".join(parts[:MOST]), more + hand] if parts else [hand])


def _place(seen: Observation, name: str, below: Sequence[tuple[str, str]] | None) -> str:
    """Return where an object is; an empty string for what is in the hand, and for what stays where it is.

    Args:
        below: what it is on or in, and how; None for such an object.
    """
    if name not in seen.positions:
        return f"{name} missing"
    unreachable = " out of reach" if name in seen.unreachable else ""
    if below is None:
        return f"{name}{unreachable}" if unreachable else ""
    if below:
        how, other = below[0]
        return f"{name} {how} {other}{unreachable}"
    x, y, _ = seen.positions[name]
    return f"{name} at ({x:.2f}, {y:.2f}) m{unreachable}"


def _below(seen: Observation, item: str) -> list[tuple[str, str]]:
    """Return what an object lies in, is on, or leans over, and how."""
    others = [other.name for other in seen.objects if other.name != item and other.size[0] <= TOO_WIDE]
    for how, relation in (("in", inside), ("on", on), ("off centre over", covers)):
        if found := [(how, other) for other in others if relation(seen, item, other)]:
            return found
    return []


def places_text(seen: Observation, names: Iterable[object]) -> str:
    """Return the positions of objects [m], and what holds of their state, as text."""
    known = [name for name in dict.fromkeys(names) if isinstance(name, str) and name in seen.positions]
    places = (", ".join(f"{value:.3f}" for value in seen.positions[name]) for name in known)
    told = [f"{name} at ({place}) m" for name, place in zip(known, places, strict=True)]
    return "; ".join([*told, *seen.facts_about(known)])


STARTS: Mapping[str, tuple[Start, int]] = {  # kind -> function, and number of trials
    "nominal": (nominal, 6),
    "perturbed": (perturbed, 10),
    "off-centre": (off_centre, 6),
    "object in hand": (object_in_hand, 4),
    "piles": (piles, 6),
    "missing object": (missing_object, 4),
}
