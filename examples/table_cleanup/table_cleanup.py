"""What `table_cleanup.ntp` leaves to Python."""

from ntp_dsl.authoring import sampler


@sampler
def dishes(rng, forks, bowls, trays):
    """Every fork into some bowl, and all bowls in a stack on a tray."""
    into = [(fork, bowls[int(rng.integers(len(bowls)))]) for fork in forks]
    stack = [str(rng.choice(trays)), *rng.permutation(bowls)]
    return into + list(zip(stack[1:], stack[:-1], strict=True))
