"""What `pasture.ntp` leaves to Python."""

from math import dist

from ntp_dsl.authoring import Failure, Outcome, predicate, sampler, skill

X = {"near": (0.31, 0.49), "far": (0.53, 0.71)}  # [m]
Y = {"left": (-0.06, 0.14), "right": (-0.32, -0.10)}
MARGIN = 0.03  # how far inside a field an animal is let go [m]


def _inside(observation, animal, field, margin):
    if animal not in observation.positions:
        return False
    x, y, _ = observation.positions[animal]
    depth, side = field.split("_")
    (near, far), (right, left) = X[depth], Y[side]
    return near + margin < x < far - margin and right + margin < y < left - margin


@predicate
def kind(observation, a):
    return {"Sheep": "sheep", "Goat": "goats"}[observation.by_name[a].type]


@predicate
def grazes(observation, a, field):
    return a != observation.held and _inside(observation, a, field, 0.01)


def _nearest(observation, animal, place):
    others = [xy for name, (*xy, _) in observation.positions.items() if name not in (animal, "table")]
    return min((dist(place, xy) for xy in others), default=1.0)


@predicate
def arrived(observation, a, field):
    if a != observation.held or not _inside(observation, a, field, MARGIN - 0.01):
        return False
    return _nearest(observation, a, observation.positions[a][:2]) > 0.06


@skill
def lead(world, a, field):
    depth, side = field.split("_")
    (near, far), (right, left) = X[depth], Y[side]
    steps = [n / 6 for n in range(7)]
    spots = [
        (near + MARGIN + s * (far - near - 2 * MARGIN), right + MARGIN + t * (left - right - 2 * MARGIN))
        for s in steps
        for t in steps
    ]
    seen = world.observe()
    best = max(spots, key=lambda spot: _nearest(seen, a, spot))
    if _nearest(seen, a, best) < 0.065:
        return Outcome(False, Failure.NO_PATH, {"the field is full": field})
    return world.move_over(*best)


@skill
def let_graze(world, a, field):
    return world.call("release", ())


@sampler
def outings(rng, sheep, goats, fields, length, topology, semantics):
    chosen = semantics.permutation([*sheep, *goats])[:length]
    return [(animal, topology.choice(fields)) for animal in chosen]
