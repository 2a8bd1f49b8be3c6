"""What `picnic.ntp` leaves to Python."""

from ntp_dsl.authoring import call, expert, first, sampler
from ntp_dsl.semantics.observation import Record


@expert
def prepare(world, guests):
    settings = [Record("Setting", (("dish", g["dish"]), ("mat", g["mat"]))) for g in guests]
    provisions = [Record("Provision", (("fruit", g["fruit"]), ("basket", g["basket"]))) for g in guests]
    return first([call("set_out", tuple(settings)), call("pack", tuple(provisions))])


@sampler
def guests(rng, dishes, mats, apples, plums, baskets, length, topology, semantics):
    dishes, fruit = semantics.permutation(dishes), semantics.permutation([*apples, *plums])
    shared = [topology.choice(baskets) for _ in dishes]
    return list(zip(dishes, topology.permutation(mats), fruit, shared, strict=False))[:length]
