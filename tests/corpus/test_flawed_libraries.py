"""Every mistake of the flawed corpus is reported, with its code and place; sound libraries raise no alarm."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest
from flawed_libraries import FOLDER, Flawed, corpus, judge

from ntp_dsl.common.resources import examples_folder, library_folder
from ntp_dsl.graph.calls import call_graph
from ntp_dsl.graph.svg import draw
from ntp_dsl.language.formatting.canonical import format_text
from ntp_dsl.language.loader import diagnose, load, read

CORPUS = corpus()
SOUND = sorted((FOLDER.parent / "sound").glob("*.ntp"))
SHIPPED = [
    *sorted(library_folder().glob("*.ntp")),
    *sorted(examples_folder().glob("*/*.ntp")),
]


@pytest.mark.parametrize("flawed", CORPUS, ids=lambda flawed: flawed.name)
def test_every_flaw_is_caught_located_and_fixed_as_expected(flawed: Flawed, tmp_path: Path) -> None:
    result = judge(flawed, tmp_path)
    assert result.wrong == ()
    for score in result.scores:
        assert score.caught and score.located and not score.why, score.why


@pytest.mark.parametrize("path", SHIPPED, ids=lambda path: path.stem)
def test_the_libraries_that_ship_have_no_diagnostics(path: Path) -> None:
    assert diagnose(path).diagnostics == ()


@pytest.mark.parametrize("path", SOUND, ids=lambda path: path.stem)
def test_a_sound_library_raises_no_alarm(path: Path) -> None:
    assert [each for each in diagnose(path).diagnostics if each.severity != "note"] == []


@pytest.mark.parametrize("path", SOUND, ids=lambda path: path.stem)
def test_a_sound_library_has_the_same_diagnostics_in_canonical_layout(path: Path, tmp_path: Path) -> None:
    for each in path.parent.iterdir():
        shutil.copy(each, tmp_path)
    copy = tmp_path / path.name
    copy.write_text(format_text(read(path), path), encoding="utf-8")
    assert format_text(read(copy), copy) == read(copy)
    told = sorted((each.code, each.message) for each in diagnose(copy).diagnostics)
    assert told == sorted((each.code, each.message) for each in diagnose(path).diagnostics)


@pytest.mark.parametrize("path", SOUND, ids=lambda path: path.stem)
def test_a_sound_library_is_drawn(path: Path) -> None:
    picture = draw(call_graph(load(path)))
    assert all(name in picture for name in load(path).tasks)


def test_most_flaws_come_with_a_fix_or_an_offer() -> None:
    expected = [each for flawed in CORPUS for each in flawed.expected]
    assert len(CORPUS) >= 500
    assert sum(each.proposal is not None for each in expected) >= 0.6 * len(expected)
