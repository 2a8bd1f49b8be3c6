"""What `kitting.ntp` leaves to Python."""

from math import hypot, inf

from ntp_dsl.authoring import predicate, sampler, skill


def _error(observation, item, tray, dx, dy):
    if item is None or not {item, tray} <= observation.positions.keys():
        return inf
    (x, y, _), (tx, ty, _) = observation.positions[item], observation.positions[tray]
    return hypot(x - tx - dx, y - ty - dy)


@predicate
def fitted(observation, part, tray, dx, dy):
    if part == observation.held or _error(observation, part, tray, dx, dy) > 0.015:
        return False
    top = observation.positions[tray][2] + observation.by_name[tray].size[2] / 2
    return abs(observation.positions[part][2] - observation.by_name[part].size[2] / 2 - top) < 0.01


@predicate
def taken(observation, other, part, tray, dx, dy):
    return other not in (part, observation.held) and _error(observation, other, tray, dx, dy) < 0.045


@predicate
def at_slot(observation, hand, tray, dx, dy):
    return _error(observation, observation.held, tray, dx, dy) < 0.012


@skill
def move_within(world, tray, dx, dy):
    x, y, _ = world.observe().positions[tray]
    return world.move_over(x + dx, y + dy)


@sampler
def slots(rng, nuts, rods, trays, length, topology, semantics):
    chosen = semantics.permutation([*nuts, *rods])[:length]
    corners = [(t, sx, sy) for t in trays for sx in (-1, 1) for sy in (-1, 1)]
    places = [corners[n] for n in topology.permutation(len(corners))[:length]]
    return [
        (part, tray, sx * float(rng.uniform(0.035, 0.06)), sy * float(rng.uniform(0.035, 0.06)))
        for part, (tray, sx, sy) in zip(chosen, places, strict=True)
    ]
