"""What `village.ntp` leaves to Python."""

from ntp_dsl.authoring import sampler


@sampler
def homes(rng, plots, walls, roofs, chimneys, yards, trees, length, topology, semantics):
    columns = (plots, walls, roofs, chimneys, yards, trees)
    places = (plots, yards)
    drawn = [(topology if column in places else semantics).permutation(column) for column in columns]
    return list(zip(*drawn, strict=False))[:length]
