"""Where lanterns stand, and which bays are lit."""

from math import hypot

from ntp_dsl.authoring import predicate, sampler, skill

BEFORE = 0.08  # the middle of two posts [m]
NEAR = 0.02  # [m]
STANDING = 0.01  # above the table, at most [m]


def _place(positions, one, other):
    """Return where a lantern lights the bay of two posts [m]."""
    (ax, ay, _), (bx, by, _) = positions[one], positions[other]
    return (ax + bx) / 2 - BEFORE, (ay + by) / 2


@predicate
def lights(observation, lantern, one, other):
    positions = observation.positions
    if not {lantern, one, other} <= positions.keys() or lantern == observation.held:
        return False
    x, y = _place(positions, one, other)
    at = positions[lantern]
    stands = at[2] < observation.by_name[lantern].size[2] / 2 + STANDING
    return stands and hypot(at[0] - x, at[1] - y) < NEAR


@skill
def set_before(world, lantern, one, other):
    moved = world.move_over(*_place(world.observe().positions, one, other))
    return world.call("release", ()) if moved else moved


@sampler
def doubtful_bays(rng, lanterns, posts, length, topology, semantics):
    """Draw bays of the inner post or of both outer ones, which are the same place, in one or two rows."""
    rows = [posts[:3], posts[3:]]
    pairs = [[(inner, inner), (first, last)][rng.integers(2)] for first, inner, last in rows]
    return [
        (lantern, *pair)
        for lantern, pair in zip(semantics.permutation(lanterns), pairs[:length], strict=False)
    ]


@sampler
def bays(rng, lanterns, posts, length, topology, semantics):
    """Draw bays that are apart: of one post, or of neighbours."""
    pairs = [(a, b) for i, a in enumerate(posts) for b in posts[i:] if {a, b} != {posts[0], posts[-1]}]
    drawn = [pairs[i] for i in topology.permutation(len(pairs))[:length]]
    return [(lantern, *pair) for lantern, pair in zip(semantics.permutation(lanterns), drawn, strict=False)]
