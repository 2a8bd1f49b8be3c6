"""The success test of the paper's authors, for goals of stacked objects."""

from __future__ import annotations

from collections.abc import Sequence
from math import hypot

from ntp_dsl.semantics.facts import Fact, Literal
from ntp_dsl.semantics.observation import Observation
from ntp_dsl.tasks.goal_samplers import Goal

MAX_OFFSET = 0.05  # between two centres, seen from above [m]


def authors_success(now: Observation, facts: Sequence[Fact], goal: Goal) -> bool | None:
    """Return whether each item is above its support and horizontally near it; None for other goals."""
    placed = all({"item", "support"} <= {name for name, _ in row.fields} for row in goal)
    stacked = all(isinstance(fact, Literal) and fact.predicate == "on" for fact in facts)
    if not (placed and stacked):
        return None
    for placement in goal:
        x, y, z = now.positions[str(placement["item"])]
        sx, sy, sz = now.positions[str(placement["support"])]
        if hypot(x - sx, y - sy) > MAX_OFFSET or z <= sz:
            return False
    return True
