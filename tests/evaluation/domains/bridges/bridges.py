"""What `bridges.ntp` leaves to Python."""

from math import hypot

from ntp_dsl.authoring import predicate, sampler, skill


def _middle(observation, left, right):
    (ax, ay, az), (bx, by, bz) = observation.positions[left], observation.positions[right]
    return (ax + bx) / 2, (ay + by) / 2, max(az, bz)


@predicate
def spans(observation, plank, left, right):
    if plank == observation.held or not {plank, left, right} <= observation.positions.keys():
        return False
    x, y, z = _middle(observation, left, right)
    px, py, pz = observation.positions[plank]
    return hypot(px - x, py - y) < 0.02 and 0.02 < pz - z < 0.04


@predicate
def between(observation, hand, left, right):
    if observation.held is None or not {left, right} <= observation.positions.keys():
        return False
    x, y, _ = _middle(observation, left, right)
    px, py, _ = observation.positions[observation.held]
    return hypot(px - x, py - y) < 0.015


@skill
def move_between(world, left, right):
    return world.move_over(*_middle(world.observe(), left, right)[:2])


@sampler
def bridges(rng, pillars, planks, length, topology, semantics):
    pairs = [(pillars[2 * n], pillars[2 * n + 1]) for n in topology.permutation(3)[:length]]
    return [(plank, *pair) for plank, pair in zip(semantics.permutation(planks), pairs, strict=False)]
