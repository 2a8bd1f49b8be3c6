"""What `hanoi.ntp` leaves to Python."""

from ntp_dsl.authoring import predicate, sampler


def discs_at(observation, p):
    """(height, width, name) of what stands over the peg."""
    return sorted(
        (observation.positions[t.name][2], t.size[0], t.name)
        for t in observation.objects
        if t.type in ("Large", "Medium", "Small") and stands(observation, t.name, p)
    )


def stands(observation, d, p):
    if d not in observation.positions or p not in observation.positions or observation.held == d:
        return False
    a, b = observation.positions[d], observation.positions[p]
    return bool(max(abs(a[0] - b[0]), abs(a[1] - b[1])) < 0.02)


at = predicate("at")(stands)


@predicate
def smaller(observation, a, b):
    return bool(observation.by_name[a].size[0] < observation.by_name[b].size[0] - 0.005)


@predicate
def spare(observation, q, d, p):
    pegs = sorted(t.name for t in observation.objects if t.type in ("Peg", "Start"))
    free = [n for n in pegs if n != p and not stands(observation, d, n)]
    return bool(free) and q == free[0]


@predicate
def seat(observation, x, d, p):
    larger = [n for _, w, n in discs_at(observation, p) if w > observation.by_name[d].size[0] + 0.005]
    return x == (larger[-1] if larger else p)


@sampler
def tower(rng, pegs, larges, mediums, smalls, discs, topology):
    peg = topology.choice(pegs)
    return [(d, peg) for d in (larges[0], mediums[0], smalls[0])][: int(discs)]


@sampler
def arrangement(rng, pegs, larges, mediums, smalls, length, topology):
    return [(d, topology.choice(pegs)) for d in (larges[0], mediums[0], smalls[0])[: int(length)]]
