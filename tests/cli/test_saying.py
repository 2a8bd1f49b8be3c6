"""Tasks that are told in sentences, on the command line."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from ntp_dsl.cli.app import run
from ntp_dsl.traces.reader import read_trace

STACKING = ["block_stacking", "few_placements", "--seed", "4"]
WORLD = ["--world", "kinematic"]
TRACE = "episode_00000.trace.jsonl"


def test_what_is_said_is_done_shown_first_and_kept_in_the_trace(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    said = ["--say", "put block 1 on block 2", "--say", "block 1 carries block 3"]
    assert run(["run", *STACKING, *WORLD, *said, "--out", str(tmp_path)]) == 0
    found = capsys.readouterr()
    assert "understood: goal: (block_1, block_2), (block_3, block_1)" in found.err
    assert "done: 2 placements" in found.out
    assert read_trace(tmp_path / TRACE).header.said == ("put block 1 on block 2", "block 1 carries block 3")
    assert run(["trace", "rerun", str(tmp_path / TRACE), "--out", str(tmp_path / "again")]) == 0
    assert run(["trace", "replay", str(tmp_path / TRACE)]) == 0


def test_sentences_may_be_in_a_file_and_be_read_as_goal_text(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "say.txt"
    file.write_text("# a tower\nput block 1 on block 2\n\nput block 3 on it\n")
    assert run(["read", *STACKING, "--say", str(file)]) == 0
    goal = tmp_path / "goal.txt"
    goal.write_text(capsys.readouterr().out)
    assert "goal: (block_1, block_2), (block_3, block_1)" in goal.read_text()
    assert run(["run", *STACKING, *WORLD, "--goal", str(goal)]) == 0


def test_what_may_mean_several_things_is_asked_and_answered(capsys: pytest.CaptureFixture[str]) -> None:
    said = ["--say", "put a block on block 2"]
    assert run(["run", *STACKING, *WORLD, *said]) == 2
    found = capsys.readouterr().err
    assert "sentence 1, 'put a block on block 2', may mean" in found and "--answer N" in found
    assert run(["run", *STACKING, *WORLD, *said, "--answer", "2"]) == 0
    assert "understood: goal: (block_1, block_2)" in capsys.readouterr().err


def test_a_sentence_changes_what_a_demonstration_shows(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(["run", *STACKING, *WORLD, "--out", str(tmp_path)]) == 0
    demo = str(tmp_path / "episode_00000.demo.parquet")
    capsys.readouterr()
    assert run(["read", *STACKING, "--demo", demo]) == 0
    shown = capsys.readouterr().out.split("goal: ")[1].strip().split("), ")
    assert run(["run", *STACKING, *WORLD, "--demo", demo, "--say", "leave out the last one"]) == 0
    assert f"understood: goal: {'), '.join(shown[:-1])}" in capsys.readouterr().err


def test_what_a_sentence_makes_of_a_demonstration_is_shown_before_anything_moves(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = tmp_path / "data"
    assert (
        run(["record", "block_stacking", "block_stacking", "-n", "1", "--seed", "3", "--out", str(folder)])
        == 0
    )
    read = ["read", *STACKING, "--demo", str(folder / "episode_00000.demo.parquet")]
    capsys.readouterr()
    assert run(read) == 0
    shown = capsys.readouterr().out.splitlines()[-1]
    assert run([*read, "--say", "leave out the last one"]) == 0
    assert capsys.readouterr().out.splitlines()[-1] == shown.rpartition(", (")[0]


def test_what_cannot_all_come_about_is_said_before_anything_moves(capsys: pytest.CaptureFixture[str]) -> None:
    task = ["set_the_table", "set_the_table", "--seed", "3"]
    assert run(["run", *task, *WORLD, "--say", "lay fork 0 left of plate 1 and left of plate 0"]) == 2
    error = capsys.readouterr().err
    assert "understood: goal: (fork_0, plate_1, left), (fork_0, plate_0, left)" in error
    assert "not all of this comes about, as a rehearsal without physics shows: beside(fork_0, plate_" in error


def test_an_evaluation_may_tell_in_words_what_is_shown_else(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["eval", "seating", "seating", "-n", "3", "--spoken", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["success"] == 1.0


def test_recorded_sentences_do_what_is_demonstrated(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = tmp_path / "data"
    record = ["record", "seating", "seating", "-n", "2", "--seed", "3", "--say", "--out", str(folder)]
    assert run(record) == 0
    capsys.readouterr()
    said = folder / "episode_00000.say.txt"
    assert said.read_text().count("\n") == 4 and "Bring guest" in said.read_text()
    assert run(["read", "seating", "seating", "--say", str(said)]) == 0
    assert run([*record[:4], "1", *record[5:]]) == 0  # what a manifest names is replaced
    assert sorted(path.name for path in folder.glob("*.say.txt")) == ["episode_00000.say.txt"]


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--say", " "], "expected a sentence"),
        (["--say", "put block 1 on block 2", "--goal", "goal.txt"], "--goal says what --say says"),
        (["--say", "put block 1 on the gherkin"], "nothing here is called 'gherkin'"),
        (["--say", "nowhere.txt"], "nowhere.txt: No such file"),
        (["--say", "put block 1 on block 2. put block 2 on block 1"], "goes round in a circle"),
    ],
)
def test_misuse_is_explained(words: list[str], message: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["run", *STACKING, *WORLD, *words]) == 2
    assert message in capsys.readouterr().err
