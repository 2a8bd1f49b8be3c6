"""The functions in Python of `zoning.ntp`."""

from math import dist, inf

from ntp_dsl.authoring import Failure, Outcome, predicate, sampler, skill

BORDERS = {"near": 0.45, "middle": 0.56, "far": inf}  # x of the farther end of each zone [m]
ROWS = {"near": 0.38, "middle": 0.5, "far": 0.62}  # x of where things are put down [m]
CLEARANCE = 0.06  # [m]


@predicate
def zone(observation, i):
    x = observation.positions[i][0] if i in observation.positions else 0.0
    return next(name for name, border in BORDERS.items() if x < border)


@skill
def set_down(world, i, z):
    seen = world.observe()
    others = [at[:2] for name, at in seen.positions.items() if name not in (i, "table")]

    def room(place):
        return min((dist(place, other) for other in others), default=inf)

    best = max(((ROWS[z], 0.04 * step) for step in range(-6, 7)), key=room)
    if room(best) < CLEARANCE:
        return Outcome(False, Failure.NO_PATH, {"no room in": z})
    moved = world.move_over(*best)
    return world.call("release", ()) if moved else moved


@sampler
def two_rules(rng, kinds, pairs, topology, semantics):
    return [(kind, str(topology.choice(["middle", "far"]))) for kind in semantics.permutation(kinds)[:pairs]]
