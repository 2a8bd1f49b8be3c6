"""The commands that run episodes, called as by a user."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from pyarrow import parquet

from ntp_dsl.cli.app import run
from ntp_dsl.common.resources import checkpoints_folder
from ntp_dsl.core.per_library.checkpoint import load_core
from ntp_dsl.demonstrations.demonstration_files import read_demonstration
from ntp_dsl.traces.reader import read_trace
from ntp_dsl.traces.schema import Ending

BASELINE = checkpoints_folder() / "baseline" / "block_stacking.safetensors"
RUN = ["run", "block_stacking", "few_placements", "--world", "kinematic"]


@pytest.fixture(scope="module")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("recorded")
    words = ["record", "block_stacking", "few_placements", "-n", "2", "--out", str(folder)]
    assert run(words) == 0
    return folder


def test_one_task_is_run_and_its_trace_is_written(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run([*RUN, "--seed", "3", "--out", str(tmp_path)]) == 0
    captured = capsys.readouterr()
    assert "pick_and_place(" in captured.out and "done:" in captured.out
    assert "no --demo: the expert demonstrates the task once, from seed 3" in captured.err
    trace = read_trace(tmp_path / "episode_00000.trace.jsonl")
    assert trace.end is not None and trace.end.ending is Ending.DONE and trace.end.success
    reference = trace.header.demonstration
    assert reference is not None
    assert reference.frames == len(read_demonstration(tmp_path / reference.file)) > 10


def test_the_scripted_expert_does_it_too_with_json_output(capsys: pytest.CaptureFixture[str]) -> None:
    assert run([*RUN, "--expert", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["success"] is True


def test_a_recorded_demonstration_is_imitated(recorded: Path) -> None:
    assert run([*RUN, "--demo", str(recorded / "episode_00001.demo.parquet")]) == 0


def test_a_demonstration_from_elsewhere_only_needs_its_columns(
    recorded: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Without header and goal, the objects are those of the scene, and the result cannot be judged."""
    table = parquet.read_table(recorded / "episode_00001.demo.parquet")
    path = tmp_path / "made_elsewhere.parquet"
    parquet.write_table(table.replace_schema_metadata(None), path)
    assert run([*RUN, "--seed", "5", "--demo", str(path), "--out", str(tmp_path / "out")]) == 0
    assert "the result was not judged" in capsys.readouterr().err
    end = read_trace(tmp_path / "out" / "episode_00000.trace.jsonl").end
    assert end is not None and end.ending is Ending.DONE and end.success is None and end.primitives > 4
    parquet.write_table(table.rename_columns([c.replace("block_0", "x") for c in table.column_names]), path)
    assert run([*RUN, "--demo", str(path)]) == 2
    assert "unknown objects x: the scene has block_0" in capsys.readouterr().err


def test_recording_writes_what_its_manifest_names(recorded: Path) -> None:
    manifest = json.loads((recorded / "manifest.json").read_text())
    assert [row["outcome"] for row in manifest["episodes"]] == ["done", "done"]
    assert len(list(recorded.iterdir())) == 5


def test_a_recording_can_be_trained_on(recorded: Path, tmp_path: Path) -> None:
    words = ["train", "block_stacking", "--data", str(recorded), "--out", str(tmp_path)]
    assert run([*words, "--iterations", "3"]) == 0
    (made,) = tmp_path.iterdir()
    recipe = load_core(made).recipe
    assert made.name == "block_stacking.safetensors"
    assert recipe["labels"]["off_stack"] == 2 and recipe["training"]["observation_noise"] == 0.002


def test_figures_are_one_document(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["eval", "block_stacking", "few_placements", "--episodes", "3", "--json"]) == 0
    figures = json.loads(capsys.readouterr().out)
    keys = "episodes success success_interval success_authors failures seconds_per_episode"
    assert {*keys.split(), "simulated_seconds_per_episode", "seed"} <= set(figures)
    assert set(figures["failures"]) == {"decision", "planner", "grasp", "physics", "disturbance"}


def damaged(kind: str, folder: Path, recorded: Path) -> Path:
    """Write an invalid demonstration."""
    path = folder / "damaged.parquet"
    whole = (recorded / "episode_00000.demo.parquet").read_bytes()
    path.write_bytes({"cut": whole[:-100], "foreign": b"PNG", "empty": b""}[kind])
    return path


@pytest.mark.parametrize("kind", ["cut", "foreign", "empty"])
def test_a_damaged_demonstration_is_one_sentence(
    kind: str, recorded: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = damaged(kind, tmp_path, recorded)
    assert run([*RUN, "--demo", str(path)]) == 2
    message = capsys.readouterr().err
    assert "expected a demonstration" in message and str(path) in message and "Traceback" not in message


def test_a_demonstration_that_lacks_an_object_of_the_scene_is_one_sentence(
    recorded: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    words = ["run", "block_stacking", "tall_towers", "--world", "kinematic", "--out", str(tmp_path)]
    assert run([*words, "--demo", str(recorded / "episode_00000.demo.parquet")]) == 2
    assert list(tmp_path.iterdir()) == []
    assert "the demonstration lacks block_8 (Block), block_9 (Block)" in capsys.readouterr().err


@pytest.mark.parametrize(
    "words, message",
    [
        (["run", "block_stacking", "juggling"], "no task is called 'juggling'"),
        ([*RUN, "--model", "nowhere.safetensors"], "no such checkpoint"),
        ([*RUN, "--demo", "nowhere.parquet"], "no such demonstration"),
        ([*RUN, "--expert", "--demo", "x.parquet"], "--expert needs no --demo"),
        (["run", "block_stacking", "few_placements", "--world", "mars"], "no world is called 'mars'"),
        (["run", "nowhere", "x"], "nowhere"),
        (["eval", "block_stacking", "block_stacking", "--tasks", "nowhere.json"], "nowhere.json"),
        (["eval", "block_stacking", "block_stacking", "--slips", "2"], "slips"),
        (["train", "block_stacking", "--data", "nowhere"], "ntp record"),
        (["demo", "--sed", "3"], "did you mean '--seed'"),
    ],
)
def test_misuse_is_one_sentence_and_status_two(
    words: list[str], message: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(words) == 2
    captured = capsys.readouterr()
    assert message in captured.err and "Traceback" not in captured.err and captured.out == ""


def test_a_checkpoint_of_another_library_is_one_sentence(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    from ntp_dsl.common.resources import examples_folder

    text = (examples_folder() / "block_stacking" / "block_stacking.ntp").read_text()
    other = text.replace("stack(goal", "pile(goal").replace("library block_stacking", "library piles")
    (tmp_path / "piles.ntp").write_text(other)
    words = ["run", str(tmp_path / "piles.ntp"), "few_placements", "--world", "kinematic"]
    assert run([*words, "--model", str(BASELINE)]) == 2
    assert "has not seen pile as library 'piles' declares" in capsys.readouterr().err


def test_a_program_declared_a_minute_ago_runs_without_training(tmp_path: Path) -> None:
    from ntp_dsl.common.resources import examples_folder

    text = (examples_folder() / "block_stacking" / "block_stacking.ntp").read_text()
    mine = text.replace("library block_stacking", "library mine").replace("stack(goal", "pile(goal")
    (tmp_path / "mine.ntp").write_text(mine.replace("8 Block", "9 Block"))
    assert run(["run", str(tmp_path), "few_placements", "--world", "kinematic"]) == 0


def test_a_task_that_fails_is_one_sentence_and_status_one(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Everything slips or is pushed, so no tower of five is built; the run is stopped with its reason."""
    words = ["run", "block_stacking", "tall_towers", "--world", "kinematic", "--expert"]
    assert run([*words, "--slips", "1", "--pushes", "1", "--out", str(tmp_path)]) == 1
    message = capsys.readouterr().err
    assert "the task failed (disturbance)" in message and "stopped: after 400 primitives" in message
    trace = read_trace(tmp_path / "episode_00000.trace.jsonl")
    assert trace.end is not None and trace.end.ending is Ending.STOPPED


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        (["run", "block_stacking", "few_placements", "--expert", "--gui"], "--gui: there is no display"),
        (["demo", "--gui"], "--gui: there is no display"),
        ([*RUN, "--expert", "--gui"], "the kinematic world has no window"),
    ],
)
def test_a_window_that_cannot_be_shown_is_misuse(
    words: list[str],
    sentence: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.delenv("DISPLAY", raising=False)
    assert run([*words, "--out", str(tmp_path)]) == 2
    captured = capsys.readouterr()
    assert sentence in captured.err and not captured.out
