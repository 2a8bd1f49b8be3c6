"""What `kitchen_pass.ntp` leaves to Python."""

from ntp_dsl.authoring import sampler


@sampler
def orders(rng, dishes, garnishes, mats, length, topology, semantics):
    dishes, garnishes = semantics.permutation(dishes), semantics.permutation(garnishes)
    return list(zip(dishes, garnishes, topology.permutation(mats), strict=False))[:length]
