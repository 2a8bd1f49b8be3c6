from ntp_dsl.authoring import predicate, skill


@predicate
def distance(observation, a, b):
    import math

    return math.dist(observation.positions[a], observation.positions[b])


@skill
def nudge(world, vial, by_length, at_speed):
    return world.call("move_to", (vial,))
