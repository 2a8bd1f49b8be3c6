from ntp_dsl.authoring import call, expert, first, predicate, sampler, skill


@expert
def boil(world, goal):
    return first(call("pick_and_place", p["egg"], p["carton"]) for p in goal)


@predicate
def warm(observation, egg):
    return observation.positions[egg][2] > 0.2


@predicate
def temperature(observation, egg):
    return 20.0


@predicate
def grade(observation, egg):
    return "small"


@skill
def tap(world, egg):
    return world.call("move_to", (egg,))


@sampler
def eggs_in(rng, eggs, cartons, grades, number):
    return list(zip(rng.permutation(eggs)[:number], rng.permutation(cartons), strict=False))
