"""Statistics of many episodes."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ntp_dsl.common.proportions import wilson
from ntp_dsl.evaluation.episodes import Episode
from ntp_dsl.evaluation.scope_agreement import ScopeAgreement, agreement
from ntp_dsl.traces.schema import Attribution

KINDS = (
    Attribution.DECISION,
    Attribution.PLANNER,
    Attribution.GRASP,
    Attribution.PHYSICS,
    Attribution.DISTURBANCE,
)


@dataclass(frozen=True)
class FailedEpisode:
    """An episode that failed, and why."""

    episode: int
    task: str
    attributed_to: Attribution | None
    reason: str
    confidence: float | None


@dataclass(frozen=True)
class Confidence:
    """How sure a policy is that it has done what was shown: means, and whether that tells the failures."""

    of_successes: float | None  # None where there are none, as the next
    of_failures: float | None
    auroc: float | None  # the probability that it is surer of a success than of a failure


@dataclass(frozen=True)
class Statistics:
    """The figures of many episodes; times are means over the episodes."""

    episodes: int
    success: float  # rate
    success_interval: tuple[float, float]  # 95 %
    success_authors: float  # rate
    failures: Mapping[Attribution, int]
    seconds_per_episode: float  # wall time
    deciding_seconds_per_episode: float  # wall time
    planning_seconds_per_episode: float  # wall time
    simulated_seconds_per_episode: float
    placements_per_episode: float
    disturbances: int
    demonstrations_repeated: int
    scopes: Mapping[str, ScopeAgreement]  # of learned programs' calls, by callee
    confidence: Confidence | None  # None where the policy says of no episode how sure it is
    failed: tuple[FailedEpisode, ...]
    seed: int


def statistics(episodes: Sequence[Episode], seed: int) -> Statistics:
    """Return the figures of episodes that were drawn from a seed."""
    count = len(episodes)
    wins = sum(bool(episode.success) for episode in episodes)
    failures = Counter(episode.attributed_to for episode in episodes if episode.attributed_to)
    return Statistics(
        episodes=count,
        success=wins / count,
        success_interval=wilson(wins, count),
        success_authors=sum(bool(episode.success_authors) for episode in episodes) / count,
        failures={kind: failures[kind] for kind in KINDS},
        seconds_per_episode=_mean(episode.wall_seconds for episode in episodes),
        deciding_seconds_per_episode=_mean(episode.deciding_seconds for episode in episodes),
        planning_seconds_per_episode=_mean(episode.planning_seconds for episode in episodes),
        simulated_seconds_per_episode=_mean(episode.simulated_seconds for episode in episodes),
        placements_per_episode=_mean(float(episode.placements) for episode in episodes),
        disturbances=sum(episode.disturbances for episode in episodes),
        demonstrations_repeated=sum(max(episode.demonstrations - 1, 0) for episode in episodes),
        scopes=agreement([episode.scopes for episode in episodes]),
        confidence=_confidence(episodes),
        failed=tuple(
            FailedEpisode(e.number, e.name, e.attributed_to, e.reason, e.confidence)
            for e in episodes
            if not e.success
        ),
        seed=seed,
    )


def _confidence(episodes: Sequence[Episode]) -> Confidence | None:
    wins = [each.confidence for each in episodes if each.success and each.confidence is not None]
    losses = [each.confidence for each in episodes if not each.success and each.confidence is not None]
    if not wins and not losses:
        return None
    pairs = [(win > loss) + 0.5 * (win == loss) for win in wins for loss in losses]
    return Confidence(
        of_successes=_mean(iter(wins)) if wins else None,
        of_failures=_mean(iter(losses)) if losses else None,
        auroc=_mean(iter(pairs)) if pairs else None,
    )


def _mean(values: Iterator[float]) -> float:
    return round(float(np.mean(list(values))), 4)
