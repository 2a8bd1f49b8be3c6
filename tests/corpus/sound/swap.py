from ntp_dsl.authoring import sampler


@sampler
def moves(rng, blocks, pads, number):
    return [(str(b), str(pads[-1 - i]), str(pads[i])) for i, b in enumerate(blocks[:number])]
