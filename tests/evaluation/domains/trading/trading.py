from ntp_dsl.authoring import sampler


@sampler
def trades(rng, parcels, starts, length):
    """Parcels of different trays, each in one trade."""
    free, found = [str(each) for each in rng.permutation(parcels)], []
    while len(found) < length:
        one = free.pop()
        other = next(each for each in free if starts[each] != starts[one])
        free.remove(other)
        found.append((one, other, starts[one], starts[other]))
    return found


@sampler
def swaps(rng, plants, starts, length):
    """Pairs of plants, none in two of them."""
    order = [str(each) for each in rng.permutation(plants)]
    pairs = [(order[2 * number], order[2 * number + 1]) for number in range(length)]
    return [(one, other, starts[one], starts[other]) for one, other in pairs]
