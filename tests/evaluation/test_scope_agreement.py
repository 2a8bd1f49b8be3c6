"""Scopes: which part of the demonstration each call reads, and what that is good for."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest
from test_other_domains import FOLDER

from ntp_dsl.common.resources import examples_folder
from ntp_dsl.core.one_core import shipped_core
from ntp_dsl.evaluation.episodes import Plan, run_all
from ntp_dsl.evaluation.scope_agreement import agreement
from ntp_dsl.language.loader import find, load
from ntp_dsl.worlds.habits import Person

EXAMPLES = sorted(each.name for each in examples_folder().iterdir() if each.is_dir())
PAINTING = Plan(FOLDER / "paint_shop", "paint_shop", shipped_core(), seed=5)


@pytest.mark.parametrize("library", EXAMPLES)
def test_each_call_reads_the_frames_of_the_experts_own_call(library: str, soak: bool) -> None:
    task = library if library in load(find(library)).tasks else "butter_in_drawer"
    plan = Plan(Path(library), task, shipped_core(), seed=5)
    found = agreement([each.scopes for each in run_all(plan, 50 if soak else 3, workers=1)])
    assert len(found) >= 4  # at each level, down to primitives
    assert {name: each.overlap for name, each in found.items() if each.overlap < 0.9} == {}


def test_what_is_handled_twice_is_told_by_the_scopes(soak: bool) -> None:
    count = 100 if soak else 5
    of_its_own = [each.success for each in run_all(PAINTING, count, workers=1)]
    of_the_whole = [each.success for each in run_all(replace(PAINTING, whole_scopes=True), count, workers=1)]
    assert sum(map(bool, of_its_own)) >= 0.95 * count
    assert sum(map(bool, of_the_whole)) <= 0.6 * count


@pytest.mark.parametrize("person", [Person.SECOND_THOUGHTS, Person.REGRASPS, Person.ANYBODY])
@pytest.mark.parametrize("domain", ["paint_shop", "washing_up"])
def test_who_fumbles_shows_them_as_well(domain: str, person: Person, soak: bool) -> None:
    count = 30 if soak else 3
    plan = Plan(FOLDER / domain, domain, shipped_core(), seed=7, demo_by=person, demo_noise=0.003)
    assert sum(bool(each.success) for each in run_all(plan, count, workers=1)) >= 0.95 * count
