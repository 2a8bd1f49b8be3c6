from ntp_dsl.authoring import sampler


@sampler
def steps(rng, bases, pegs, plates, stages, count):
    rows = []
    for part in [*pegs, *plates][:count]:
        support = bases[len(rows)] if len(rows) < len(bases) else rows[-1][0]
        rows.append((part, support, "first"))
    return rows
