"""The sampler of `lorry.ntp`."""

from ntp_dsl.authoring import sampler


@sampler
def manifest(rng, crates, length):
    """Draw stops 1 to 4 on both sides; the last stop comes first in the list."""
    places = [(stop, lane) for lane in ("port", "starboard") for stop in (4, 3, 2, 1)]
    chosen = sorted(rng.permutation(len(places))[:length])
    return [(c, *places[k]) for c, k in zip(rng.permutation(crates), chosen, strict=False)]
