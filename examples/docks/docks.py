"""The functions in Python of `docks.ntp`."""

from math import dist

from ntp_dsl.authoring import call, expert, first, predicate

COST = 12.0  # of a metre, in units of urgency
WANTED = 3  # docks
NEAR = 0.04  # of a parcel from the middle of its dock [m]


@predicate
def way(observation, dock, van):
    return dist(observation.positions[dock][:2], observation.positions[van][:2])


@predicate
def relieved(observation, van):
    docks = [each for each in observation.objects if each.type == "Dock"]
    parcels = [each.name for each in observation.objects if each.type == "Parcel"]
    places = [
        observation.positions[each]
        for each in parcels
        if each in observation.positions and each != observation.held
    ]

    def is_full(dock):
        at = observation.positions[dock.name]
        return any(dist(place[:2], at[:2]) < NEAR for place in places)

    def claim(dock):
        return dict(dock.traits)["urgency"] - COST * way(observation, dock.name, van)

    full = [claim(each) for each in docks if is_full(each)]
    empty = [claim(each) for each in docks if not is_full(each)]
    return len(empty) >= WANTED and (not full or max(full) < min(empty))


@expert
def relieve(world, van):
    def claim(dock):
        return world.urgency(dock) - COST * world.way(dock, van)

    docks = sorted(world.objects("Dock"), key=claim, reverse=True)
    return first(call("unload", dock, van) for dock in docks if world.full(dock))
