"""What `garden_rows.ntp` leaves to Python."""

from math import hypot, inf

from ntp_dsl.authoring import predicate, sampler, skill


def _error(observation, item, origin, distance):
    if item is None or not {item, origin} <= observation.positions.keys():
        return inf
    (x, y, _), (ox, oy, _) = observation.positions[item], observation.positions[origin]
    return hypot(x - ox - distance, y - oy)


@predicate
def ahead(observation, item, origin, distance):
    if item == observation.held or _error(observation, item, origin, distance) > 0.015:
        return False
    return observation.positions[item][2] < observation.by_name[item].size[2] / 2 + 0.01


@predicate
def hovers(observation, hand, origin, distance):
    return _error(observation, observation.held, origin, distance) < 0.012


@predicate
def obstructs(observation, other, origin, distance):
    return other not in (origin, observation.held) and _error(observation, other, origin, distance) < 0.055


@skill
def carry_ahead(world, origin, distance):
    x, y, _ = world.observe().positions[origin]
    return world.move_over(x + distance, y)


@sampler
def rows(rng, pots, labels, stakes, length, topology, semantics):
    columns = semantics.permutation(pots), semantics.permutation(labels), topology.permutation(stakes)
    return [(*names, float(rng.uniform(0.055, 0.105))) for names in list(zip(*columns, strict=True))[:length]]
