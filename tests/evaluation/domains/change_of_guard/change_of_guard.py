"""What `change_of_guard.ntp` leaves to Python."""

from ntp_dsl.authoring import sampler


@sampler
def reliefs(rng, sentries, sleepers, length, topology, semantics, starts):
    pairs = zip(topology.permutation(sentries), semantics.permutation(sleepers), strict=True)
    return [(old, new, starts[old], starts[new]) for old, new in list(pairs)[:length]]
