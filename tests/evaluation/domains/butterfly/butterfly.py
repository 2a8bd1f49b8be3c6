"""What `butterfly.ntp` leaves to Python."""

from math import hypot, inf

from ntp_dsl.authoring import predicate, sampler, skill


def _error(observation, stone, spine, ahead, aside):
    if stone is None or not {stone, spine} <= observation.positions.keys():
        return inf
    (x, y, _), (sx, sy, _) = observation.positions[stone], observation.positions[spine]
    return hypot(x - sx - ahead, y - sy - aside)


@predicate
def lies(observation, s, spine, ahead, aside):
    if s == observation.held or _error(observation, s, spine, ahead, aside) > 0.015:
        return False
    return observation.positions[s][2] < observation.by_name[s].size[2] / 2 + 0.01


@predicate
def poised(observation, hand, spine, ahead, aside):
    return _error(observation, observation.held, spine, ahead, aside) < 0.012


@predicate
def occupies(observation, s, spine, ahead, aside):
    return s != observation.held and _error(observation, s, spine, ahead, aside) < 0.055


@skill
def carry_off(world, spine, ahead, aside):
    x, y, _ = world.observe().positions[spine]
    return world.move_over(x + ahead, y + aside)


@sampler
def wings(rng, pebbles, shells, spines, length, topology, semantics):
    pebbles = semantics.permutation(pebbles)
    twins = [tuple(pebbles[:2]), tuple(pebbles[2:]), tuple(semantics.permutation(shells))]
    twins = [twins[n] for n in semantics.permutation(3)[:length]]
    rows = topology.permutation([-0.12, 0.0, 0.12])
    signs = topology.choice([-1, 1], size=3)
    return [
        (*pair, spines[0], float(row + rng.uniform(-0.02, 0.02)), float(sign * rng.uniform(0.07, 0.16)))
        for pair, row, sign in zip(twins, rows, signs, strict=False)
    ]
