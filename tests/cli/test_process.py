"""The process of a command: signals, closed streams, poor encodings, full disks and killed workers."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import suppress
from pathlib import Path

import pytest
from safetensors import safe_open

from ntp_dsl.cli.app import INTERRUPTION, run
from ntp_dsl.common.workers import KILLED
from ntp_dsl.traces.reader import read_trace

NTP = [sys.executable, "-m", "ntp_dsl"]
GRAPH = [*NTP, "graph", "block_stacking"]
EVAL = [*NTP, "eval", "block_stacking", "few_placements", "--expert", "--episodes", "100000", "--json"]
LONGEST_WAIT = 600.0  # [s] far more than a busy machine takes


def listen() -> None:
    """Undo what a shell does to the tests in its background: they, and their children, ignore the signal."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)


def wait_until(true: Callable[[], object]) -> None:
    end = time.monotonic() + LONGEST_WAIT
    while not true():
        assert time.monotonic() < end
        time.sleep(0.05)


Start = Callable[[list[str]], "subprocess.Popen[str]"]


@pytest.fixture
def started() -> Iterator[Start]:
    """Start commands, each in a session of its own; none outlives its test."""
    processes: list[subprocess.Popen[str]] = []

    def start(words: list[str]) -> subprocess.Popen[str]:
        pipe = subprocess.PIPE
        processes.append(
            subprocess.Popen(
                words, stdout=pipe, stderr=pipe, text=True, preexec_fn=listen, start_new_session=True
            )
        )
        return processes[-1]

    yield start
    for process in processes:
        with suppress(ProcessLookupError):
            os.killpg(process.pid, signal.SIGKILL)
        process.wait()
        for stream in (process.stdout, process.stderr):
            if stream is not None:
                stream.close()


def children(process: int) -> list[int]:
    """Return the processes of `multiprocessing` that a process started, without its resource tracker."""
    listed = Path(f"/proc/{process}/task/{process}/children").read_text().split()
    return [int(each) for each in listed if b"spawn_main" in Path(f"/proc/{each}/cmdline").read_bytes()]


@pytest.mark.parametrize("workers", ["1", "2"])
@pytest.mark.parametrize("sent", [signal.SIGINT, signal.SIGTERM])
def test_an_interrupted_evaluation_reports_the_episodes_so_far(
    sent: signal.Signals, workers: str, tmp_path: Path, started: Start
) -> None:
    words = [*EVAL, "--workers", workers, "--out", str(tmp_path)]
    process = started(words)
    wait_until(lambda: len(list(tmp_path.glob("*.jsonl"))) > 20)
    if sent is signal.SIGINT:
        os.killpg(process.pid, sent)  # as a terminal does
    else:
        process.send_signal(sent)
    out, err = process.communicate(timeout=LONGEST_WAIT)
    document = json.loads(out)
    assert (process.returncode, err.splitlines()) == (130, [INTERRUPTION])
    assert document["interrupted"] is True and document["episodes_wanted"] == 100_000
    assert 0 < document["episodes"] <= len(list(tmp_path.glob("*.jsonl")))


def test_an_evaluation_that_ends_says_so(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["eval", "block_stacking", "few_placements", "--expert", "--episodes", "2", "--json"]) == 0
    document = json.loads(capsys.readouterr().out)
    assert (document["episodes"], document["episodes_wanted"], document["interrupted"]) == (2, 2, False)


def test_a_killed_worker_is_a_sentence_that_says_what_to_do(started: Start) -> None:
    process = started([*EVAL, "--workers", "2"])
    wait_until(lambda: len(children(process.pid)) == 2)
    time.sleep(1)
    os.kill(children(process.pid)[0], signal.SIGKILL)
    _, err = process.communicate(timeout=LONGEST_WAIT)
    assert (process.returncode, err.splitlines()) == (2, [KILLED])


def test_an_interrupted_recording_leaves_whole_files(tmp_path: Path, started: Start) -> None:
    words = "record block_stacking few_placements -n 100000 --workers 2 --out".split()
    process = started([*NTP, *words, str(tmp_path)])
    wait_until(lambda: len(list(tmp_path.glob("episode_*.parquet"))) > 4)
    os.killpg(process.pid, signal.SIGINT)
    _, err = process.communicate(timeout=LONGEST_WAIT)
    assert (process.returncode, err.splitlines()) == (130, [INTERRUPTION])
    for path in tmp_path.glob("episode_*.jsonl"):
        assert read_trace(path).end is not None
    assert not list(tmp_path.glob(".episode*")) and (tmp_path / "manifest.json").is_file()


@pytest.mark.minutes  # when the signal comes hangs on the machine, so this is no test of every day
@pytest.mark.parametrize("after", [0.25, 0.5, 0.75, 1.0, 1.5])
def test_ctrl_c_during_imports_is_one_line(after: float, started: Start) -> None:
    """Python's own start is left out: what it prints then is not ours."""
    process = started([*NTP, "run", "block_stacking", "few_placements", "--world", "kinematic", "--json"])
    wait_until(lambda: b"block_stacking" in Path(f"/proc/{process.pid}/cmdline").read_bytes())
    time.sleep(after)
    process.send_signal(signal.SIGINT)
    _, err = process.communicate(timeout=LONGEST_WAIT)
    if "__main__" in err or "ntp_dsl" in err or process.returncode >= 0:
        assert "Traceback" not in err and process.returncode in (0, 130)


@pytest.mark.parametrize("words", [GRAPH, [*GRAPH, "--list"], [*NTP, "--help"], [*NTP, "check", "--help"]])
def test_a_reader_that_leaves_ends_the_command_quietly(words: list[str], started: Start) -> None:
    process = started(words)
    assert process.stdout is not None and process.stderr is not None
    process.stdout.close()
    assert process.stderr.read() == ""
    assert process.wait() == 141


def test_closed_streams_are_no_error() -> None:
    words = ["sh", "-c", '"$@" >&- 2>&-', "sh", *GRAPH]
    assert subprocess.run(words, check=False).returncode == 0


def test_a_full_standard_output_is_a_sentence() -> None:
    with Path("/dev/full").open("w") as full:
        done = subprocess.run(GRAPH, stdout=full, stderr=subprocess.PIPE, text=True, check=False)
    assert done.returncode == 2 and "standard output: No space left on device" in done.stderr
    assert len(done.stderr.splitlines()) == 1


@pytest.mark.parametrize(
    "poor",
    [
        {"PYTHONIOENCODING": "ascii"},
        {"PYTHONIOENCODING": "latin-1"},
        {"LC_ALL": "C", "PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0"},
    ],
)
@pytest.mark.parametrize("words", ["graph block_stacking", "run block_stacking few_placements --expert"])
def test_a_poor_encoding_prints_with_replacements(words: str, poor: dict[str, str]) -> None:
    world = ["--world", "kinematic"] if words.startswith("run") else []
    environment = {**os.environ, **poor}
    done = subprocess.run([*NTP, *words.split(), *world], env=environment, capture_output=True, check=False)
    assert (done.returncode, b"Traceback" in done.stderr) == (0, False)
    assert b"pick_and_place" in done.stdout


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("recording")
    assert run(["record", "block_stacking", "few_placements", "-n", "2", "--out", str(folder)]) == 0
    return folder


def test_a_full_disk_after_training_loses_nothing(
    recording: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    made = tmp_path / "block_stacking.safetensors"
    made.symlink_to("/dev/full")
    words = ["train", "block_stacking", "--data", str(recording), "--out", str(tmp_path), "--iterations", "3"]
    assert run(words) == 2
    err = capsys.readouterr().err
    partial = tmp_path / "training.safetensors"
    assert "No space left on device; the training so far is in" in err and str(partial) in err
    with safe_open(partial, "pt") as kept:
        assert json.loads(kept.metadata()["recipe"])["iteration"] == 3
    made.unlink()
    assert run(words) == 0
    assert "continuing from iteration 3" in capsys.readouterr().err
    assert [path.name for path in tmp_path.iterdir()] == [made.name]


def test_a_demonstration_of_another_episode_is_refused(
    recording: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    trace = recording / "episode_00000.trace.jsonl"
    other = recording / "episode_00001.demo.parquet"
    assert run(["trace", "replay", str(trace), "--demo", str(other)]) == 2
    assert "the trace is of a demonstration of" in capsys.readouterr().err
    words = ["record", "block_stacking", "tall_towers", "-n", "1", "--out", str(tmp_path)]
    assert run(words) == 0
    capsys.readouterr()
    other = tmp_path / "episode_00000.demo.parquet"
    assert run(["trace", "replay", str(trace), "--demo", str(other)]) == 2
    assert "the demonstration also shows block_8 (Block), block_9 (Block)" in capsys.readouterr().err
