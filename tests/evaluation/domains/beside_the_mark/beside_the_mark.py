"""What `beside_the_mark.ntp` leaves to Python."""

from itertools import product
from math import hypot, inf

from ntp_dsl.authoring import predicate, sampler, skill


def _place(observation, mark, side, distance):
    x, y, _ = observation.positions[mark]
    return x, y + (distance if side == "left" else -distance)


def _error(observation, peg, mark, side, distance):
    if not {peg, mark} <= observation.positions.keys():
        return inf
    x, y = _place(observation, mark, side, distance)
    px, py, _ = observation.positions[peg]
    return hypot(px - x, py - y)


@predicate
def laid(observation, peg, mark, side, distance):
    if peg == observation.held or _error(observation, peg, mark, side, distance) > 0.02:
        return False
    return observation.positions[peg][2] < 0.05


@predicate
def ready(observation, hand, mark, side, distance):
    return bool(observation.held) and _error(observation, observation.held, mark, side, distance) < 0.015


@predicate
def in_the_way(observation, other, mark, side, distance):
    return observation.held != other and _error(observation, other, mark, side, distance) < 0.06


@skill
def shift(world, mark, side, distance):
    return world.move_over(*_place(world.observe(), mark, side, distance))


@sampler
def spots(rng, pegs, marks, sides, length, topology, semantics):
    slots = topology.permutation(list(product(marks, sides)))[:length]
    chosen = semantics.permutation(pegs)[:length]
    pairs = zip(chosen, slots, strict=True)
    return [(peg, mark, side, float(rng.uniform(0.1, 0.2))) for peg, (mark, side) in pairs]
