"""What `table_cleanup.ntp` leaves to Python."""

from ntp_dsl.authoring import sampler


@sampler
def dishes(rng, forks, bowls, trays, topology, semantics, length=None):
    """So many forks, or all of them, each into some bowl; and all bowls in a stack on a tray."""
    forks, bowls = semantics.permutation(forks)[:length], semantics.permutation(bowls)
    into = [(fork, bowls[int(topology.integers(len(bowls)))]) for fork in forks]
    stack = [str(rng.choice(trays)), *topology.permutation(bowls)]
    return into + list(zip(stack[1:], stack[:-1], strict=True))
