"""What `sandwiches.ntp` leaves to Python."""

from ntp_dsl.authoring import sampler


@sampler
def sandwiches(rng, plates, slices, cheeses, tomatoes, length, topology, semantics):
    bread, fillings = semantics.permutation(slices), semantics.permutation([*cheeses, *tomatoes])
    return list(zip(topology.permutation(plates), bread[::2], fillings, bread[1::2], strict=False))[:length]
