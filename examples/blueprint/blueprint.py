"""The functions in Python of `blueprint.ntp`."""

from ntp_dsl.authoring import call, expert, first, sampler


@expert
def build(world, plan):
    """Place next any object whose support is settled."""
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
    """Draw two towers of `height` and three blocks, or those left, with the placements in any order."""
    names = list(rng.permutation(blocks))
    towers = names[:height], names[height : height + 3]
    pairs = [pair for tower in towers for pair in zip(tower[1:], tower, strict=False)]
    return [pairs[index] for index in rng.permutation(len(pairs))]
