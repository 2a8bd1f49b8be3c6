from ntp_dsl.authoring import sampler


@sampler
def planting(rng, roses, herbs, beds, pairs):
    things = [*roses, *herbs]
    return list(zip(rng.permutation(things)[:pairs], rng.permutation(beds), strict=False))
