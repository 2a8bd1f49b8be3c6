"""The functions in Python of `sky.ntp`."""

from math import hypot

from ntp_dsl.authoring import predicate, sampler, skill


def _between(observation, star, origin, axis, least, most):
    seen = observation.positions
    return star in seen and origin in seen and least <= seen[star][axis] - seen[origin][axis] <= most


@predicate
def deeper(observation, star, origin, least, most):
    return _between(observation, star, origin, 0, least, most)


@predicate
def lefter(observation, star, origin, least, most):
    return _between(observation, star, origin, 1, least, most)


@predicate
def apart_from_hand(observation, star, origin):
    return observation.held not in (star, origin)


@predicate
def hovering(observation, hand, origin, ahead, left):
    seen = observation.positions
    if not observation.held or origin not in seen:
        return False
    (x, y, _), (ox, oy, _) = seen[observation.held], seen[origin]
    return hypot(x - ox - ahead, y - oy - left) < 0.008


@skill
def hover(world, star, origin, ahead, left):
    x, y, _ = world.observe().positions[origin]
    return world.move_over(x + ahead, y + left)


@sampler
def rays(rng, poles, stars, length, topology, semantics):
    """Draw a tree of stars on a grid of 7 cm around the pole, no two at one place."""
    places, result = {(0, 0): poles[0]}, []
    for star in semantics.permutation(stars)[:length]:
        steps = [
            (old, (dx, dy))
            for old in places
            for dx in (-1, 0, 1)
            for dy in (-1, 0, 1)
            if (old[0] + dx, old[1] + dy) not in places and abs(old[0] + dx) < 3 and abs(old[1] + dy) < 3
        ]
        old, (dx, dy) = steps[int(topology.integers(len(steps)))]
        places[old[0] + dx, old[1] + dy] = star
        result.append((star, places[old], 0.07 * dx, 0.07 * dy))
    return result
