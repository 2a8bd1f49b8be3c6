"""Which mug is rinsed where, and where it is put away."""

from ntp_dsl.authoring import sampler


@sampler
def jobs(rng, mugs, basins, racks, length, topology, semantics):
    rows = zip(
        semantics.permutation(mugs), topology.permutation(basins), topology.permutation(racks), strict=True
    )
    return list(rows)[:length]
