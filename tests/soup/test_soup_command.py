"""`ntp soup`: files that are kept, refused or checked."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from ntp_dsl.cli.app import run
from ntp_dsl.soup import random_library


def test_a_file_is_written_for_each_seed(tmp_path: Path) -> None:
    out = tmp_path / "soup"
    assert run(["soup", "--count", "3", "--seed", "5", "--out", str(out)]) == 0
    assert {path.name: path.read_text() for path in out.iterdir()} == {
        f"soup_{seed}.ntp": random_library(seed) for seed in (5, 6, 7)
    }


def test_the_same_files_are_kept_and_others_never_replaced(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    words = ["soup", "-n", "2", "--out", str(tmp_path)]
    assert run(words) == 0
    before = (tmp_path / "soup_0.ntp").stat().st_mtime_ns
    assert run(words) == 0
    assert (tmp_path / "soup_0.ntp").stat().st_mtime_ns == before
    (tmp_path / "soup_2.ntp").write_text("library mine\n")
    assert run(["soup", "-n", "4", "--out", str(tmp_path)]) == 2
    assert "soup_2.ntp exists and is another text" in capsys.readouterr().err
    assert not (tmp_path / "soup_3.ntp").exists()
    assert (tmp_path / "soup_2.ntp").read_text() == "library mine\n"


def test_a_check_says_how_many_are_sound(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    assert run(["soup", "-n", "1", "--check", "--json", "--out", str(tmp_path)]) == 0
    document = json.loads(capsys.readouterr().out)
    assert (document["count"], document["sound"]) == (1, 1)
    assert document["libraries"] == [{"path": str(tmp_path / "soup_0.ntp"), "errors": []}]
