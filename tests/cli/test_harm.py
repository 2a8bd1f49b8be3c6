"""Nothing of a user's is deleted or replaced unasked, and nothing foreign is run."""

from __future__ import annotations

import json
import multiprocessing
from pathlib import Path

import pytest

from ntp_dsl.cli.app import run
from ntp_dsl.common.files import locked, written_whole
from ntp_dsl.datasets.manifest import MANIFEST

RECORD = ["record", "block_stacking", "few_placements", "-n", "1"]
FLAWED = """library flawed
program p(x: Nowhere):
    achieves holding(x)
"""


def contents(folder: Path) -> dict[str, bytes]:
    return {str(path.relative_to(folder)): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("recording")
    assert run([*RECORD, "--out", str(folder)]) == 0
    return folder


@pytest.mark.parametrize(
    "words, said",
    [
        (["record", "block_stacking", "few_placments"], "did you mean 'few_placements'"),
        ([*RECORD, "--world", "moon"], "no world is called 'moon'"),
        ([*RECORD, "--world", "bullet", "--arm", "nope"], "nope"),
        ([*RECORD, "--length", "100"], "100 placements in towers of at most 3"),
        ([*RECORD, "--perturbation-rate", "nan"], "found nan"),
        (["record", "FLAWED", "t"], "Nowhere"),
    ],
)
def test_what_cannot_be_recorded_leaves_an_earlier_recording_as_it_was(
    words: list[str],
    said: str,
    recording: Path,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:
    (tmp_path / "flawed.ntp").write_text(FLAWED)
    before = contents(recording)
    words = [str(tmp_path / "flawed.ntp") if word == "FLAWED" else word for word in words]
    assert run([*words, "--out", str(recording)]) == 2
    assert said in capsys.readouterr().err and contents(recording) == before


def test_an_earlier_recording_is_replaced_and_nothing_else(recording: Path, tmp_path: Path) -> None:
    folder = tmp_path / "data"
    folder.mkdir()
    for name, text in contents(recording).items():
        (folder / name).write_bytes(text)
    assert run([*RECORD, "--seed", "9", "--out", str(folder)]) == 0
    assert contents(folder).keys() == contents(recording).keys() and contents(folder) != contents(recording)


@pytest.mark.parametrize("name", ["notes.md", "episode_guide.md", "episode_00007.trace.jsonl", MANIFEST])
def test_a_folder_with_other_files_is_refused(
    name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / name).write_text('{"name": "a manifest of something else"}')
    before = contents(tmp_path)
    assert run([*RECORD, "--out", str(tmp_path)]) == 2
    assert "choose another folder" in capsys.readouterr().err and contents(tmp_path) == before


def test_overwriting_leaves_what_is_no_recordings(tmp_path: Path) -> None:
    for name in ("notes.md", "episode_guide.md", "episode_00007.trace.jsonl"):
        (tmp_path / name).write_text("mine")
    assert run([*RECORD, "--overwrite", "--out", str(tmp_path)]) == 0
    kept = contents(tmp_path)
    assert kept["notes.md"] == kept["episode_guide.md"] == b"mine"
    assert "episode_00007.trace.jsonl" not in kept and "episode_00000.trace.jsonl" in kept


def hold(folder: str, ready: object, done: object) -> None:
    with locked(Path(folder)):
        ready.set()  # type: ignore[attr-defined]
        done.wait(60)  # type: ignore[attr-defined]


def test_two_recordings_into_one_folder_are_one_error(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    context = multiprocessing.get_context("spawn")
    ready, done = context.Event(), context.Event()
    other = context.Process(target=hold, args=(str(tmp_path), ready, done))
    other.start()
    try:
        assert ready.wait(60)
        assert run([*RECORD, "--out", str(tmp_path)]) == 2
        assert "another process is recording into this folder" in capsys.readouterr().err
    finally:
        done.set()
        other.join()
    assert run([*RECORD, "--out", str(tmp_path)]) == 0


def test_a_manifest_says_how_many_episodes_were_wanted(recording: Path) -> None:
    manifest = json.loads((recording / MANIFEST).read_text())
    assert manifest["wanted"] == len(manifest["episodes"]) == 1


def test_a_link_is_followed_and_a_device_is_written_to(tmp_path: Path) -> None:
    real, link = tmp_path / "real.txt", tmp_path / "link.txt"
    real.write_text("old")
    link.symlink_to(real)
    with written_whole(link) as partial:
        partial.write_text("new")
    assert link.is_symlink() and real.read_text() == "new"
    with written_whole(Path("/dev/null")) as partial:
        partial.write_text("gone")
    assert Path("/dev/null").is_char_device()
    with pytest.raises(IsADirectoryError), written_whole(tmp_path) as partial:
        partial.write_text("nothing")


def test_a_full_device_is_a_sentence_and_stays_a_device(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["graph", "block_stacking", "--out", "/dev/full"]) == 2
    assert "No space left on device" in capsys.readouterr().err and Path("/dev/full").is_char_device()


def test_a_trace_does_not_choose_whose_python_is_run(
    recording: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    """A folder at hand that is called as the trace's library is not the library that is meant."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "block_stacking").mkdir()
    (tmp_path / "block_stacking" / "block_stacking.ntp").write_text(FLAWED)
    trace = recording / "episode_00000.trace.jsonl"
    assert run(["trace", "replay", str(trace), "--expert"]) == 0
    capsys.readouterr()
    header, rest = trace.read_text().split("\n", 1)
    for name in ("./block_stacking", str(tmp_path / "block_stacking"), "../x", "evil\x1b[2J"):
        changed = tmp_path / "changed.jsonl"
        changed.write_text(json.dumps({**json.loads(header), "library": name}) + "\n" + rest)
        assert run(["trace", "replay", str(changed), "--expert"]) == 2
        told = capsys.readouterr().err
        assert "which is no example: give its path with --library" in told and "\x1b" not in told


@pytest.mark.parametrize("option", ["--slips", "--pushes", "--noise"])
def test_nan_is_no_probability(option: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["eval", "block_stacking", "few_placements", "--episodes", "1", option, "nan"]) == 2
    assert "found nan" in capsys.readouterr().err


def test_a_name_in_a_task_file_cannot_command_the_terminal(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    objects = [{"name": "a\x1b]0;x\x07", "type": "Block", "size": [0.05] * 3}]
    tasks = [{"id": "\x1b[2J", "objects": objects, "goal": [{"item": "a", "support": "b"}]}]
    file = tmp_path / "tasks.json"
    file.write_text(json.dumps({"format": "ntp-tasks", "version": 2, "tasks": tasks}))
    assert run(["eval", "block_stacking", "block_stacking", "--tasks", str(file)]) == 2
    told = capsys.readouterr()
    assert "expected a printable name" in told.err and "\x1b" not in told.err + told.out


def test_a_range_that_runs_backwards_is_told_so(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["eval", "block_stacking", "block_stacking", "--expert", "-n", "1", "--topology", "5..3"]) == 2
    assert "--topology: the range 5..3 runs backwards; write 3..5" in capsys.readouterr().err


@pytest.mark.parametrize("version, advice", [(9, "update ntp"), (True, "record anew"), ("1", "record anew")])
def test_a_manifest_of_another_version_is_refused(
    recording: Path, tmp_path: Path, version: object, advice: str, capsys: pytest.CaptureFixture[str]
) -> None:
    manifest = json.loads((recording / MANIFEST).read_text())
    (tmp_path / MANIFEST).write_text(json.dumps(manifest | {"version": version}))
    assert run(["train", "block_stacking", "--data", str(tmp_path), "--out", str(tmp_path / "model")]) == 2
    told = capsys.readouterr().err
    assert f"expected version 2 of the format, found {version!r}" in told and advice in told
