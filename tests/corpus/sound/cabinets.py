from ntp_dsl.authoring import skill


@skill
def pull(world, drawer, distance):
    return world.call("move_to", (drawer,))


@skill
def push(world, drawer, force):
    return world.call("move_to", (drawer,))
