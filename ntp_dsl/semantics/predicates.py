"""The built-in predicates: geometry of one observation. Distances are in metres."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from math import hypot

from ntp_dsl.language.diagnostics.diagnostics import NtpError
from ntp_dsl.semantics import attempts, layout
from ntp_dsl.semantics.containers import is_over_hollow, lies_in, takes
from ntp_dsl.semantics.free_space import FREE_GAP, clearance, footprints, load
from ntp_dsl.semantics.observation import Observation

ANY = "any"
ANY_KNOWN = frozenset({"holding"})  # predicates that say of themselves whether they hold of anything
CENTRED = 0.015  # the target of programs; success tests accept more, so that no choice is borderline
ACCEPTED = 0.025  # half a cube
OVER = 0.025  # of an empty hand from the object to grasp, seen from above
OVERLAP = 0.9  # of an object's width: centres nearer than this overlap, seen from above
FLOOR_BELOW = 0.003  # how far a container's floor may be below the surface that it stands on [m]
TOUCHING = 0.012  # gap up to which an object counts as resting on the one below


def held(observation: Observation) -> str | None:
    """Return the object between the closed fingers, or None."""
    return observation.held


def present(observation: Observation, target: str) -> bool:
    return target in observation.positions


def reachable(observation: Observation, target: str) -> bool:
    return target in observation.positions and target not in observation.unreachable


def holding(observation: Observation, item: str) -> bool:
    in_hand = held(observation)
    return in_hand is not None and item in (ANY, in_hand)


def empty(observation: Observation, gripper: str) -> bool:
    return held(observation) is None


def on(observation: Observation, item: str, support: str, within: float = CENTRED) -> bool:
    """Return whether `item` rests on `support`, its centre within that distance of the support's.

    On a roomy surface it does not where something thin is between them, or where it lies in a bin there.
    """
    if not rests_on(observation, item, support, within):
        return False
    return not (observation.by_name[support].roomy and _is_above_another(observation, item, support))


def _is_above_another(observation: Observation, item: str, surface: str) -> bool:
    """Return whether an item near a roomy surface rests on, or lies in, something else."""
    top = observation.positions[surface][2] + observation.by_name[surface].size[2] / 2
    for other in observation.objects:
        if other.name in (item, surface) or other.name not in observation.positions:
            continue
        if covers(observation, item, other.name):
            return True
        if other.cavity is not None and inside(observation, item, other.name):
            floor = observation.positions[other.name][2] - other.size[2] / 2 + other.cavity.floor
            if floor > top - FLOOR_BELOW:  # else the surface itself is in it
                return True
        is_higher = observation.positions[other.name][2] + other.size[2] / 2 > top
        if other.roomy and is_higher and rests_on(observation, item, other.name):
            return True
    return False


def rests_on(observation: Observation, item: str, support: str, within: float = CENTRED) -> bool:
    """Return whether `item` is right above `support`, as far as these two tell."""
    if not _resting(observation, item, support):
        return False
    x, y, _ = observation.positions[item]
    sx, sy, _ = observation.positions[support]
    below = observation.by_name[support]
    if below.roomy:
        beside = max(abs(x - sx) - below.size[0] / 2, abs(y - sy) - below.size[1] / 2)
        return beside < 0 and abs(_gap(observation, item, support)) < TOUCHING
    return hypot(x - sx, y - sy) < within and abs(_gap(observation, item, support)) < TOUCHING


def covers(observation: Observation, item: str, support: str) -> bool:
    """Return whether `item` stands on or leans over `support`, centred or not: it is in the way."""
    if not _resting(observation, item, support) or observation.by_name[support].roomy:
        return False
    x, y, _ = observation.positions[item]
    sx, sy, _ = observation.positions[support]
    above, below = observation.by_name[item].size, observation.by_name[support].size
    reach_x, reach_y = (OVERLAP * (above[axis] + below[axis]) / 2 for axis in (0, 1))
    near = abs(x - sx) < reach_x and abs(y - sy) < reach_y
    sunk = 0.6 * min(above[2], below[2])  # an object that leans, or stands beside, is lower than on top
    return near and -sunk < _gap(observation, item, support) < 0.5 * above[2]


def clear(observation: Observation, item: str) -> bool:
    """Return whether nothing covers `item`."""
    return present(observation, item) and not any(
        covers(observation, obj.name, item) for obj in observation.objects
    )


def above(observation: Observation, gripper: str, target: str) -> bool:
    """Return whether the held object, or else the gripper, is over `target` (a table: a free place of it)."""
    if not present(observation, target):
        return False
    in_hand = held(observation)
    if in_hand == target:
        return False
    surface = observation.by_name[target]
    if takes(surface, observation.by_name[in_hand]) if in_hand else surface.cavity is not None:
        return _over_container(observation, in_hand, target)
    x, y, z = observation.positions[in_hand] if in_hand else observation.gripper
    tx, ty, tz = observation.positions[target]
    if surface.flat:
        if max(abs(x - tx) - surface.size[0] / 2, abs(y - ty) - surface.size[1] / 2) >= 0:
            return False
        size = observation.by_name[in_hand].size if in_hand else (0.0, 0.0)
        others = footprints(observation, {in_hand, target, *load(observation, in_hand)})
        return bool(clearance((x, y), size, others) > FREE_GAP)
    rise = observation.gripper[2] - (tz + surface.size[2] / 2)
    within = CENTRED if in_hand else OVER
    return hypot(x - tx, y - ty) < within and 0.03 < rise < 0.2


def _over_container(observation: Observation, in_hand: str | None, target: str) -> bool:
    """Return whether the held object can drop into the hollow, or an empty hand can grasp the rim."""
    x, y, z = observation.positions[in_hand] if in_hand else observation.gripper
    tx, ty, tz = observation.positions[target]
    obj = observation.by_name[target]
    rise = observation.gripper[2] - (tz + obj.size[2] / 2)
    if in_hand is None:  # a bowl is grasped by its wall
        return abs(hypot(x - tx, y - ty) - obj.size[0] / 2) < OVER and 0.03 < rise < 0.2
    return is_over_hollow(obj, (tx, ty, tz), x, y) and z > tz and rise < 0.25


def inside(observation: Observation, item: str, container: str) -> bool:
    """Return whether `item` lies in the hollow of `container`, or heaped on its contents."""
    both = present(observation, item) and present(observation, container) and item != container
    if not both or item == held(observation):
        return False
    objects, positions = observation.by_name, observation.positions
    return lies_in(objects[item], positions[item], objects[container], positions[container])


def hollow(observation: Observation, item: str) -> bool:
    """Return whether `item` is a bin or a bowl: narrower objects released over it fall in."""
    return item in observation.by_name and observation.by_name[item].cavity is not None


def stands_on(observation: Observation, item: str, support: str) -> bool:
    """Return whether `item` rests on `support` or in it, centred or not."""
    return covers(observation, item, support) or inside(observation, item, support)


def _resting(observation: Observation, item: str, support: str) -> bool:
    both = present(observation, item) and present(observation, support) and item != support
    return both and observation.by_name[item].movable and item != held(observation)


def _gap(observation: Observation, item: str, support: str) -> float:
    """Return the gap from the support's top to the item's bottom [m]."""
    bottom = observation.positions[item][2] - observation.by_name[item].size[2] / 2
    return bottom - (observation.positions[support][2] + observation.by_name[support].size[2] / 2)


class MissingTrait(NtpError):
    """The scene gives an object no such trait."""


def trait(name: str) -> Callable[[Observation, str], str | float]:
    """Return a reading of a trait that the task's scene gives its objects.

    The reading raises `MissingTrait` for an object without that trait.
    """

    def read(observation: Observation, obj: str) -> str | float:
        traits = dict(observation.by_name[obj].traits) if obj in observation.by_name else {}
        if name not in traits:
            raise MissingTrait(f"the scene gives '{obj}' no {name}; write: ... with {name}(...)")
        return traits[name]

    return read


READINGS: dict[str, Callable[..., float]] = {"failures": attempts.failures}
BUILT_IN: dict[str, Callable[..., bool]] = {
    "present": present,
    "reachable": reachable,
    "holding": holding,
    "empty": empty,
    "on": on,
    "covers": covers,
    "in": inside,
    "hollow": hollow,
    "clear": clear,
    "above": above,
    "beside": layout.beside,
    "over_side": layout.over_side,
    "room_beside": layout.room_beside,
    "turned": layout.turned,
    "aligned": layout.aligned,
}
JUDGED = BUILT_IN | {"on": partial(on, within=ACCEPTED)}  # as a success test reads them
