"""Other domains: relations of three objects, numeric offsets, exchanges, objects in the way."""

from __future__ import annotations

from pathlib import Path

import pytest
from evaluation_lines import learnt

from ntp_dsl.evaluation.episodes import Plan, run_all
from ntp_dsl.worlds.protocol import Disturbances

FOLDER = Path(__file__).parent / "domains"
DOMAINS = sorted(path.name for path in FOLDER.iterdir())


@pytest.mark.parametrize("world, count", [("kinematic", 20), ("bullet", 1)])
@pytest.mark.parametrize("domain", DOMAINS)
def test_its_expert_succeeds_although_objects_slip(domain: str, world: str, count: int) -> None:
    plan = Plan(FOLDER / domain, domain, None, world, seed=1, disturbances=Disturbances(slips=0.15))
    failed = [(each.number, each.reason) for each in run_all(plan, count, workers=1) if not each.success]
    assert not failed


@pytest.mark.minutes
@pytest.mark.parametrize("domain", DOMAINS)
def test_it_is_learnt_from_fifty_demonstrations(domain: str, tmp_path: Path) -> None:
    plan = Plan(FOLDER / domain, domain, learnt(FOLDER / domain, tmp_path), seed=7)
    assert sum(episode.success for episode in run_all(plan, 200, workers=2)) >= 0.85 * 200
