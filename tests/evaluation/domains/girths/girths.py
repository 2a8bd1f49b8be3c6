"""The sampler of `girths.ntp`."""

from ntp_dsl.authoring import sampler

SIZES = [0.020, 0.028, 0.036, 0.044]  # [m]


@sampler
def grades(rng, racks, length, topology, semantics):
    cuts = sorted(topology.permutation([1, 2, 3])[: length - 1])  # the grades share no pipe
    parts = list(zip([0, *cuts], [*cuts, 4], strict=True))
    return [
        (r, SIZES[a], SIZES[b - 1]) for r, (a, b) in zip(semantics.permutation(racks), parts, strict=False)
    ]
