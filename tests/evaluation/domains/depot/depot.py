"""What `depot.ntp` leaves to Python."""

from ntp_dsl.authoring import predicate

HANDLING = {"Letter": "flat", "Crate": "heavy", "Vase": "fragile"}


@predicate
def handling(observation, p):
    return HANDLING[observation.by_name[p].type]
