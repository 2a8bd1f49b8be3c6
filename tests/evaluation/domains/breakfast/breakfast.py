from math import radians

from ntp_dsl.authoring import sampler

SIDES = ("left", "right", "front", "behind")


@sampler
def at_some_side(rng, cups, plates):
    """Each mug at a side of a plate of its own."""
    shuffled = rng.permutation(cups)
    return [(cup, plate, str(rng.choice(SIDES))) for cup, plate in zip(shuffled, plates, strict=True)]


@sampler
def at_some_angle(rng, knives, mats):
    """Each knife on a mat of its own, at 30 to 90 degrees to either side."""
    return [
        (knife, mat, radians(float(rng.choice((-1, 1)) * rng.uniform(30, 90))))
        for knife, mat in zip(rng.permutation(knives), mats, strict=True)
    ]
