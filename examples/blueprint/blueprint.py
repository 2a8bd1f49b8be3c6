"""What `blueprint.ntp` leaves to Python."""

from ntp_dsl.authoring import call, expert, first, sampler


@expert
def build(world, plan):
    """Whatever stands on something settled can come next."""
    supports = {p["item"]: p["support"] for p in plan}

    def settled(obj):
        return obj not in supports or (world.on(obj, supports[obj]) and settled(supports[obj]))

    return first(
        call("pick_and_place", item, support)
        for item, support in sorted(supports.items())
        if not settled(item) and settled(support)
    )


@sampler
def shuffled_towers(rng, blocks, height):
    """Two towers of `height` and three blocks, or what is left, in any order of the placements."""
    names = list(rng.permutation(blocks))
    towers = names[:height], names[height : height + 3]
    pairs = [pair for tower in towers for pair in zip(tower[1:], tower, strict=False)]
    return [pairs[index] for index in rng.permutation(len(pairs))]
