"""Every mistake of the flawed corpus is told, with its code and place; sound libraries raise no alarm."""

from __future__ import annotations

from pathlib import Path

import pytest
from flawed_libraries import FOLDER, Flawed, corpus, scores

from ntp_dsl.language.loader import diagnose
from ntp_dsl.resources import examples_folder, library_folder

CORPUS = corpus()
SOUND = [
    *sorted((FOLDER.parent / "sound").glob("*.ntp")),
    *sorted(library_folder().glob("*.ntp")),
    *sorted(examples_folder().glob("*/*.ntp")),
]


@pytest.mark.parametrize("flawed", CORPUS, ids=lambda flawed: flawed.name)
def test_every_flaw_is_caught_located_and_mended_as_expected(flawed: Flawed, tmp_path: Path) -> None:
    for score, expected in zip(scores(flawed, tmp_path), flawed.expected, strict=True):
        assert score.caught and score.located, score.why
        assert score.fixed or not expected.has_fix, score.why


@pytest.mark.parametrize("path", SOUND, ids=lambda path: path.stem)
def test_nothing_is_said_of_a_sound_library(path: Path) -> None:
    assert diagnose(path).diagnostics == ()


def test_most_flaws_come_with_a_fix() -> None:
    expected = [each for flawed in CORPUS for each in flawed.expected]
    assert len(CORPUS) >= 110
    assert sum(each.has_fix for each in expected) >= 0.6 * len(expected)
