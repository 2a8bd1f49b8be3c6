"""Every mistake of the flawed corpus is told, with its code and place; sound libraries raise no alarm."""

from __future__ import annotations

from pathlib import Path

import pytest
from flawed_libraries import FOLDER, Flawed, corpus, found_in, scores

from ntp_dsl.resources import examples_folder, library_folder

CORPUS = corpus()
SOUND = [
    *sorted((FOLDER.parent / "sound").glob("*.ntp")),
    *sorted(library_folder().glob("*.ntp")),
    *sorted(examples_folder().glob("*/*.ntp")),
]


@pytest.mark.parametrize("flawed", CORPUS, ids=lambda flawed: flawed.name)
def test_every_flaw_is_caught_and_located(flawed: Flawed, tmp_path: Path) -> None:
    for score in scores(flawed, tmp_path):
        assert score.caught and score.located, score.why


@pytest.mark.parametrize("path", SOUND, ids=lambda path: path.stem)
def test_nothing_is_said_of_a_sound_library(path: Path, tmp_path: Path) -> None:
    assert found_in(path.read_text(encoding="utf-8"), tmp_path) == ()


def test_most_flaws_come_with_a_fix_that_leads_to_a_library_that_checks(tmp_path: Path) -> None:
    found = [score for flawed in CORPUS for score in scores(flawed, tmp_path)]
    assert len(CORPUS) >= 110
    assert sum(score.fixed for score in found) >= 0.35 * len(found)
