from ntp_dsl.authoring import ACHIEVED, Failure, Outcome, sampler, skill


@skill
def pull(world, d):
    """Open a drawer that is not jammed."""
    drawer = world.truth().by_name[d]
    world.settle(0.5)
    return Outcome(False, Failure.NO_PATH, {"jammed": d}) if dict(drawer.traits)["is_stuck"] else ACHIEVED


@sampler
def some_of(rng, drawers):
    """Half of the drawers, in some order."""
    return [(each,) for each in rng.permutation(drawers)[:2]]
