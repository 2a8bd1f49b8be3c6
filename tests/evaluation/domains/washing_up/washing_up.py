"""Which mug is rinsed where, and where it is put away."""

from ntp_dsl.authoring import sampler


@sampler
def jobs(rng, mugs, basins, racks, length, topology, semantics):
    places = zip(topology.permutation(basins), topology.permutation(racks), strict=True)
    return [(mug, *pair) for mug, pair in zip(semantics.permutation(mugs)[:length], places, strict=False)]
