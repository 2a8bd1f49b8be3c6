"""What a trace records is run again from its seed, and goes as it went; a run that was cut off goes on."""

from __future__ import annotations

import json
from pathlib import Path
from random import Random
from shutil import copy

import pytest

import ntp_dsl
from ntp_dsl.cli.app import run
from ntp_dsl.traces.reader import read_trace

EVAL = "eval block_stacking few_placements -n 2 --seed 3 --slips .4".split()
KINDS = {
    "scripted": ["--expert"],
    "learned": [],
    "noisy": ["--noise", ".015", "--demo-noise", ".01"],
    "shown by a person": ["--demo-by", "anybody", "--demo-noise", ".003"],
    "by the rule": ["--dispatch", "rule"],
}
TRACE = "episode_00001.trace.jsonl"


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("to_run_again")
    for name, words in KINDS.items():
        assert run([*EVAL, *words, "--out", str(path / name), "--json"]) == 0
    return path


@pytest.mark.parametrize("kind", KINDS)
def test_a_run_goes_as_it_went(
    kind: str, folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    capsys.readouterr()
    assert run(["trace", "rerun", str(folder / kind / TRACE), "--out", str(tmp_path), "--json"]) == 0
    assert json.loads(capsys.readouterr().out) == {"same": True, "first": None}


@pytest.mark.parametrize("kind", KINDS)
def test_a_run_that_was_cut_off_anywhere_goes_on_to_the_same_end(
    kind: str, folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    whole = folder / kind / TRACE
    rows = whole.read_bytes().splitlines(keepends=True)
    cut = tmp_path / "cut" / TRACE
    cut.parent.mkdir()
    cut.write_bytes(b"".join(rows[: Random(kind).randrange(5, len(rows) - 1)]))
    copy(folder / kind / "episode_00001.demo.parquet", cut.parent)
    assert run(["trace", "rerun", str(cut), "--out", str(tmp_path)]) == 0
    assert ", and went on: " in capsys.readouterr().out
    assert ntp_dsl.compare(read_trace(whole), read_trace(tmp_path / TRACE)).first is None


def test_a_run_to_a_goal_that_was_told_goes_as_it_went(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    words = ["block_stacking", "few_placements", "--seed", "4"]
    capsys.readouterr()
    assert run(["read", *words]) == 0
    goal = tmp_path / "goal.txt"
    goal.write_text(capsys.readouterr().out)
    told = tmp_path / "told"
    assert run(["run", *words, "--world", "kinematic", "--goal", str(goal), "--out", str(told)]) == 0
    goal.unlink()
    capsys.readouterr()
    trace = str(told / "episode_00000.trace.jsonl")
    assert run(["trace", "rerun", trace, "--out", str(tmp_path), "--json"]) == 0
    assert json.loads(capsys.readouterr().out) == {"same": True, "first": None}


def test_what_is_forced_makes_it_another_run(
    folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    words = ["--inject", "grasp=grasp_failed", "--out", str(tmp_path)]
    assert run(["trace", "rerun", str(folder / "learned" / TRACE), *words]) == 1
    assert "first divergence: outcome, attributed to disturbance" in capsys.readouterr().out


def test_a_trace_is_not_replaced_by_its_own_rerun(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = folder / "learned" / TRACE
    before = file.read_bytes()
    assert run(["trace", "rerun", str(file), "--out", str(file.parent)]) == 2
    assert "would be overwritten" in capsys.readouterr().err and file.read_bytes() == before


def test_what_is_missing_is_named(folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    alone = tmp_path / "alone" / TRACE
    alone.parent.mkdir()
    alone.write_bytes((folder / "learned" / TRACE).read_bytes())
    assert run(["trace", "rerun", str(alone), "--out", str(tmp_path)]) == 2
    assert "episode_00001.demo.parquet, does not lie beside it" in capsys.readouterr().err
    rows = alone.read_text(encoding="utf-8").replace("core.safetensors", "none.safetensors")
    alone.write_text(rows, encoding="utf-8")
    assert run(["trace", "rerun", str(alone), "--out", str(tmp_path)]) == 2
    assert "is not there: give --model FILE" in capsys.readouterr().err
