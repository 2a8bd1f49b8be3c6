"""A hand that handles the objects of a kinematic world at random; for states that no program leads to."""

from __future__ import annotations

import numpy as np

from ntp_dsl.worlds.kinematic import KinematicWorld

CHOICES, SHARES = ("get", "put", "move"), (0.4, 0.4, 0.2)


def handle_at_random(world: KinematicWorld, rng: np.random.Generator) -> None:
    """Move over a random object; then, perhaps, grasp it, or put down what is held."""
    seen = world.truth()
    target = str(rng.choice([obj.name for obj in seen.objects]))
    choice = str(rng.choice(CHOICES, p=SHARES))
    world.skills["move_to"](target)
    if choice == "get" and seen.held is None:
        world.skills["grasp"](target)
    elif choice == "put" and seen.held is not None:
        world.skills["release"]()
