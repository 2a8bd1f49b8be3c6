"""The expert of `dishes.ntp`."""

from ntp_dsl.authoring import call, expert, first


@expert
def wash_up(world, tub, rack):
    """See first to what leaves the water clear, then to the rest, the least greasy first."""
    dishes = sorted(world.objects("Dish"), key=lambda d: (world.grease(d), d))
    return first(call("see_to", dish, tub, rack) for dish in dishes)
