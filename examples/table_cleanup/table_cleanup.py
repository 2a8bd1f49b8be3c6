"""The functions in Python of `table_cleanup.ntp`."""

from ntp_dsl.authoring import predicate, sampler

OVERLAP = 0.01  # of their height ranges, above which one object is in another's way [m]


@predicate
def crowds(observation, other, item, support):
    if observation.held == other or other in (item, support):
        return False
    if support not in observation.positions or other not in observation.positions:
        return False
    objects = [observation.by_name[name] for name in (other, item, support)]
    if objects[2].cavity is not None and any(obj.cavity is None for obj in objects):
        return False  # contents of a hollow are not in the way
    (width, depth, height), own, below = (obj.size for obj in objects)
    (x, y, z), (sx, sy, sz) = observation.positions[other], observation.positions[support]
    near = abs(x - sx) < (width + own[0]) / 2 and abs(y - sy) < (depth + own[1]) / 2
    bottom = sz + below[2] / 2  # of the item, once it is placed
    shared = min(z + height / 2, bottom + own[2]) - max(z - height / 2, bottom)
    return near and shared > OVERLAP


@sampler
def dishes(rng, forks, bowls, trays, topology, semantics, length=None):
    """Draw `length` forks (all by default), each into some bowl; and all bowls in a stack on a tray."""
    forks, bowls = semantics.permutation(forks)[:length], semantics.permutation(bowls)
    into = [(fork, bowls[int(topology.integers(len(bowls)))]) for fork in forks]
    stack = [str(rng.choice(trays)), *topology.permutation(bowls)]
    return into + list(zip(stack[1:], stack[:-1], strict=True))
