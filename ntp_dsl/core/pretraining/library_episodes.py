"""Decisions in random libraries: the expert runs their tasks in trouble, as a core perceives it."""

from __future__ import annotations

import numpy as np

from ntp_dsl.core.perception.grounding import Grounding
from ntp_dsl.core.pretraining.dispatch_data import Sample, Watching
from ntp_dsl.execution.interpreter import Interpreter, Limits
from ntp_dsl.language.diagnostics.diagnostics import NtpError
from ntp_dsl.language.loader import load_text
from ntp_dsl.policies.expert import Expert
from ntp_dsl.soup import random_library
from ntp_dsl.tasks.instances import draw
from ntp_dsl.worlds.catalogue import make_world
from ntp_dsl.worlds.protocol import Disturbances

NOISES = (0.0, 0.004, 0.008, 0.012, 0.016, 0.02)  # standard, of a look [m]
PERTURBED = 0.4  # of the starts
TASKS = 3  # of a library, at most
PRIMITIVES = 60  # of an episode
TROUBLE = 0.15  # of slips, pushes and misses, each


def decisions(library: int, network: Grounding) -> list[Sample]:
    """Return the decisions in the tasks of a random library; the same for the same number."""
    registry = load_text(random_library(library))
    world, expert = make_world("kinematic", registry), Expert(registry)
    found: list[Sample] = []
    for number, task in enumerate(list(registry.tasks.values())[:TASKS]):
        rng = np.random.default_rng((library, number))
        try:
            instance = draw(registry, task, rng)
            start = instance.perturbed_start if rng.random() < PERTURBED else instance.nominal_start
            scene = start(rng)
        except NtpError:  # there was no room
            continue
        noise = float(rng.choice(NOISES))
        world.reset(scene, int(rng.integers(2**31)), Disturbances(TROUBLE, TROUBLE, noise, TROUBLE))
        watching = Watching(expert, network)
        limits = Limits(primitives=PRIMITIVES)
        Interpreter(registry, watching, world, limits=limits).run(instance.program, instance.arguments)
        found += watching.samples
    return found
