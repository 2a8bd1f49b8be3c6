"""What `reflection.ntp` leaves to Python."""

from ntp_dsl.authoring import sampler


@sampler
def views(rng, nears, fars, slabs, drums, length, topology, semantics):
    slabs, drums = semantics.permutation(slabs), semantics.permutation(drums)
    rows = []
    for number, near in enumerate(topology.permutation(nears)):
        far = fars[list(nears).index(near)]  # across the water
        pairs = [slabs[2 * number : 2 * number + 2], drums[2 * number : 2 * number + 2]]
        (lower, lower_twin), (upper, upper_twin) = pairs if topology.integers(2) else pairs[::-1]
        rows.append((near, lower, upper, far, lower_twin, upper_twin))
    return rows[:length]
