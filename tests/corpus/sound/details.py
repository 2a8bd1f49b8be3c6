from ntp_dsl.authoring import sampler


@sampler
def some_things(rng, forks, mugs, parts, pots, crates, number):
    things = [*forks, *mugs, *parts]
    return [(str(x), str(rng.choice(crates))) for x in rng.permutation(things)[:number]]
