"""Commands that take a trace take folders of them, too: pairs have equal names."""

from __future__ import annotations

import json
from pathlib import Path
from shutil import copy

import pytest

from ntp_dsl.cli.app import run

Folders = tuple[Path, Path]


@pytest.fixture(scope="module")
def folders(tmp_path_factory: pytest.TempPathFactory) -> Folders:
    """Return two folders of traces: three of the expert, and four of the core, in which things slip."""
    path = tmp_path_factory.mktemp("folders")
    words = ["eval", "block_stacking", "few_placements"]
    assert run([*words, "-n", "3", "--expert", "--out", str(path / "expert")]) == 0
    assert run([*words, "-n", "4", "--slips", "0.9", "--out", str(path / "learned")]) == 0
    return path / "expert", path / "learned"


def test_each_pair_that_differs_has_a_line(folders: Folders, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["trace", "diff", *map(str, folders)]) == 1
    shown = capsys.readouterr()
    lines = shown.out.splitlines()
    assert "1 trace of" in shown.err and "without a counterpart" in shown.err
    (total,) = [line for line in lines if "pairs the same" in line]
    different = [line for line in lines if line.startswith("episode_")]
    assert total == f"{3 - len(different)} of 3 pairs the same" and different
    assert sum(int(line.split()[0]) for line in lines if " × " in line) == len(different)


def test_the_pairs_are_those_that_are_compared_one_by_one(
    folders: Folders, capsys: pytest.CaptureFixture[str]
) -> None:
    run(["trace", "diff", *map(str, folders), "--json"])
    document = json.loads(capsys.readouterr().out)
    assert len(document["pairs"]) == 3
    for row in document["pairs"]:
        run(["trace", "diff", *(str(folder / row["file"]) for folder in folders), "--json"])
        assert json.loads(capsys.readouterr().out)["first"] == row["first"]


def test_a_folder_is_the_same_as_itself(folders: Folders, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["trace", "diff", str(folders[1]), str(folders[1])]) == 0
    assert "4 of 4 pairs the same" in capsys.readouterr().out


def test_all_traces_of_a_folder_are_replayed(folders: Folders, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["trace", "replay", str(folders[0]), "--expert", "--json"]) == 0
    document = json.loads(capsys.readouterr().out)
    assert len(document["traces"]) == 3 and document["asked"] == document["right"] > 0
    assert document["asked"] == sum(row["asked"] for row in document["traces"])
    run(["trace", "replay", str(folders[1])])
    assert "decisions as in 4 traces" in capsys.readouterr().out


def test_the_first_pair_that_differs_is_viewed(
    folders: Folders, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    run(["trace", "diff", *map(str, folders), "--json"])
    pairs = json.loads(capsys.readouterr().out)["pairs"]
    first = next(row["file"] for row in pairs if row["first"] is not None)
    assert run(["trace", "view", *map(str, folders), "--out", str(tmp_path / "a.html")]) == 0
    assert f"of 3 pairs: {first}" in capsys.readouterr().err
    assert run(["trace", "view", str(folders[1]), "--out", str(tmp_path / "b.html")]) == 0
    assert "of 4 traces: episode_00000" in capsys.readouterr().err


@pytest.mark.parametrize("command", ["diff", "view"])
def test_a_folder_and_a_trace_are_no_pair(
    command: str, folders: Folders, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = next(folders[0].glob("*.trace.jsonl"))
    assert run(["trace", command, str(folders[0]), str(file)]) == 2
    assert "expected two traces, or two folders" in capsys.readouterr().err
    (tmp_path / "other").mkdir()
    copy(file, tmp_path / "other" / "another.trace.jsonl")
    assert run(["trace", command, str(folders[0]), str(tmp_path / "other")]) == 2
    assert "no traces of the same names" in capsys.readouterr().err


def test_of_a_folder_the_first_failure_is_explained(
    tmp_path: Path, folders: Folders, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(["trace", "explain", str(folders[0])]) == 0
    shown = capsys.readouterr()
    assert "episode_00000.trace.jsonl: none failed" in shown.err and " succeeded." in shown.out
    words = ["eval", "block_stacking", "few_placements", "--seed", "5", "--slips", "1", "--noise", ".1"]
    run([*words, "-n", "2", "--out", str(tmp_path)])
    capsys.readouterr()
    run(["trace", "show", str(tmp_path), "--json"])
    failed = [row["file"] for row in json.loads(capsys.readouterr().out) if not row["success"]]
    assert run(["trace", "explain", str(tmp_path)]) == 0
    shown = capsys.readouterr()
    assert failed and f"{failed[0]}: the first of {len(failed)} that failed, of 2 traces" in shown.err
    assert run(["trace", "explain", str(tmp_path / failed[0])]) == 0
    assert capsys.readouterr().out == shown.out
    (tmp_path / "damaged.trace.jsonl").write_text("no trace", encoding="utf-8")
    assert run(["trace", "explain", str(tmp_path)]) == 0
    told = capsys.readouterr()
    assert "1 trace cannot be read: left out" in told.err and told.out == shown.out


def test_what_is_for_one_trace_is_refused(folders: Folders, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["trace", "replay", str(folders[0]), "--expert", "--out", "a.jsonl"]) == 2
    assert "for one trace" in capsys.readouterr().err
