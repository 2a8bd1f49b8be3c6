"""Libraries that were never seen run from one demonstration, without training."""

from __future__ import annotations

import pytest
from one_core_samples import read, the_model

from ntp_dsl.api import demonstrate, draw, run
from ntp_dsl.evaluation.episode_parts import NoDemonstration
from ntp_dsl.language.loader import load_text
from ntp_dsl.soup import random_library
from ntp_dsl.worlds.protocol import UNDISTURBED, Disturbances

FIRST = 5000  # no training made libraries of these seeds
FEW, MANY = 6, 100
EPISODES = 2  # of each task, with `--soak`
LEAST = 0.97  # of the episodes succeed


def outcomes(count: int, episodes: int, disturbances: Disturbances) -> tuple[int, list[str]]:
    """Return how many episodes were run, and what failed."""
    failed, total = [], 0
    for library in range(FIRST, FIRST + count):
        registry = load_text(random_library(library))
        for name in registry.tasks:
            for seed in range(episodes):
                task = draw(registry, name, seed)
                try:
                    shown = demonstrate(task).demonstration
                except NoDemonstration:
                    continue  # what an expert cannot show is the library's own matter
                total += 1
                policy = the_model(registry, task.instance.program).shown(shown)
                episode = run(task, policy, disturbances=disturbances)
                if not episode.success:
                    failed.append(f"soup {library} {name} {seed}: {episode.verdict}")
    return total, failed


@pytest.mark.parametrize("disturbances", [UNDISTURBED, Disturbances(slips=0.25, noise=0.002)])
def test_an_unseen_library_runs_from_one_demonstration(disturbances: Disturbances, soak: bool) -> None:
    total, failed = outcomes(MANY if soak else FEW, EPISODES if soak else 1, disturbances)
    assert total >= FEW and len(failed) <= (1 - LEAST) * total, (total, failed)


def test_what_their_hands_do_is_explained(soak: bool) -> None:
    acts = explained = 0
    for library in range(FIRST, FIRST + (MANY if soak else FEW)):
        registry = load_text(random_library(library))
        for name in registry.tasks:
            task = draw(registry, name, 0)
            try:
                found = read(task, demonstrate(task).demonstration)
            except NoDemonstration:
                continue
            acts, explained = acts + found.acts, explained + found.explained
    assert explained >= 0.95 * acts > 0, (explained, acts)
