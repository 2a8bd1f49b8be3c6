"""Which pot is filled where, and where it is put away."""

from ntp_dsl.authoring import sampler


@sampler
def jobs(rng, pots, *taps_and_more, length, topology, semantics):
    taps = [tap for group in taps_and_more for tap in group]
    drawn = [taps[i] for i in topology.permutation(len(taps))]
    return list(zip(semantics.permutation(pots)[:length], drawn[:length], drawn[length:], strict=False))
