"""What `table_cleanup.ntp` leaves to Python."""

from ntp_dsl.authoring import predicate, sampler


@predicate
def crowds(observation, other, item, support):
    if observation.held == other or other in (item, support) or support not in observation.positions:
        return False
    if other not in observation.positions or observation.by_name[support].cavity is not None:
        return False  # what goes into a hollow comes down within its rim
    (x, y, z), (sx, sy, sz) = observation.positions[other], observation.positions[support]
    (width, depth, height), (_, _, below) = observation.by_name[other].size, observation.by_name[support].size
    own = observation.by_name[item].size
    near = abs(x - sx) < (width + own[0]) / 2 and abs(y - sy) < (depth + own[1]) / 2
    return near and z - height / 2 < sz + below / 2 < z + height / 2


@sampler
def dishes(rng, forks, bowls, trays, topology, semantics, length=None):
    """So many forks, or all of them, each into some bowl; and all bowls in a stack on a tray."""
    forks, bowls = semantics.permutation(forks)[:length], semantics.permutation(bowls)
    into = [(fork, bowls[int(topology.integers(len(bowls)))]) for fork in forks]
    stack = [str(rng.choice(trays)), *topology.permutation(bowls)]
    return into + list(zip(stack[1:], stack[:-1], strict=True))
