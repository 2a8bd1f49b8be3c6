"""The parameters of a pretraining, and how a core tells that it had fewer than usual."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any

from ntp_dsl.common.decoding import Count


@dataclass(frozen=True)
class PretrainingConfig:
    """The parameters of a pretraining; part of a core's recipe."""

    seed: Count = 0
    scenes: Count = 9000  # that are made up, for the grounding
    iterations: Count = 12000  # of the grounding
    programs: Count = 60000  # nameless ones, for the dispatcher
    sequences: Count = 5000  # of nameless calls that follow from one another, for the dispatcher
    libraries: Count = 500  # random ones, for the dispatcher
    dispatch_iterations: Count = 10000


FEWER = 0.5  # of the usual number, below which it is told


def fewer_than_usual(pretraining: Any) -> str:
    """Return which numbers of a pretraining were far below the usual ones; empty where none was.

    Args:
        pretraining: as a core's file states it.
    """
    if not isinstance(pretraining, Mapping):
        return ""
    usual = asdict(PretrainingConfig())
    low = [
        f"{given} of {count} {name.replace('_', ' ')}"
        for name, count in usual.items()
        if isinstance(given := pretraining.get(name), int) and given < FEWER * count
    ]
    return ", ".join(low)
