from ntp_dsl.authoring import skill


@skill
def turn(world, knob, by_how_much, direction):
    return world.call("move_to", (knob,))


@skill
def press(world, button, force, duration):
    return world.call("move_to", (button,))


@skill
def wait(world, duration):
    return world.call("release", ())


@skill
def hold_still(world):
    return world.call("release", ())
