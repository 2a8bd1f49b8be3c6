"""What `line_up.ntp` leaves to Python."""

from ntp_dsl.authoring import predicate, sampler, skill


def spot(observation, after, gap):
    x, y = observation.positions[after][:2]
    return x, y + gap


def distance(observation, o, after, gap):
    x, y = spot(observation, after, gap)
    p = observation.positions[o]
    return max(abs(p[0] - x), abs(p[1] - y))


@predicate
def beside(observation, item, after, gap):
    if item not in observation.positions or after not in observation.positions or observation.held == item:
        return False
    low = observation.positions[item][2] - observation.by_name[item].size[2] / 2 < 0.02
    return bool(low and distance(observation, item, after, gap) < 0.012)


@predicate
def in_the_way(observation, o, after, gap):
    there = o in observation.positions and after in observation.positions
    if o == after or not there or observation.held == o:
        return False
    return bool(distance(observation, o, after, gap) < 0.07)


@skill
def set_down(world, item, after, gap):
    x, y = spot(world.observe(), after, gap)
    over = world.move_over(x, y)
    if not over.achieved:
        return over
    return world.call("release", ())


@sampler
def rows(rng, marks, blocks, pins, slabs, length, topology, semantics):
    items = list(semantics.permutation([*blocks, *pins, *slabs]))[:length]
    before = marks[0]
    rows = []
    for item in items:
        rows.append((item, before, float(topology.choice([0.09, 0.11, 0.13]))))
        before = item
    return rows
