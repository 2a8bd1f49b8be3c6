from ntp_dsl.authoring import sampler


@sampler
def packs(rng, items, fragile, cartons, number):
    things = [*items, *fragile]
    return [(str(x), str(rng.choice(cartons))) for x in rng.permutation(things)[:number]]
