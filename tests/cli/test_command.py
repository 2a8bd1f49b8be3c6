"""The command: answers on standard output, errors in a sentence, and an exit status that tells them apart."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from ntp_dsl.cli import app
from ntp_dsl.cli.app import run
from ntp_dsl.cli.groups import COMMANDS
from ntp_dsl.language.diagnostics.diagnostics import NtpError, TaskFailed

UNSOUND = "library a\nuse tabletop\ntype Cup is Movabel\nprogam go():\n"


def output(capsys: pytest.CaptureFixture[str], *words: str) -> tuple[int, str, str]:
    """Run a command, and return exit status, standard output and standard error."""
    status = run(words)
    captured = capsys.readouterr()
    assert "Traceback" not in captured.err
    return status, captured.out, captured.err


def test_a_sound_library_is_reported_as_sound(capsys: pytest.CaptureFixture[str]) -> None:
    status, out, err = output(capsys, "check", "--static", "block_stacking", "tabletop")
    assert (status, err) == (0, "")
    assert out.startswith("sound: ") and "tabletop.ntp" in out


def test_errors_are_printed_with_their_locations(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    (tmp_path / "a.ntp").write_text(UNSOUND)
    status, out, _ = output(capsys, "check", str(tmp_path))
    assert status == 1
    assert "a.ntp:4:1" in out and "progam go():\n   | ^^^^^^" in out
    assert out.endswith("3 errors found (2 fixable with --fix)\n")


def test_errors_are_one_json_document(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    (tmp_path / "a.ntp").write_text(UNSOUND.rsplit("progam")[0])
    status, out, err = output(capsys, "check", str(tmp_path), "--format", "json")
    document = json.loads(out)
    assert (status, err, document["sound"]) == (1, "", False)
    (row,) = document["diagnostics"]
    assert (row["code"], row["line"], row["column"]) == ("E103", 3, 13)
    assert row["fix"]["replacement"] == "Movable" and row["path"].endswith("a.ntp")


def test_an_error_of_a_shared_library_is_reported_once(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    (tmp_path / "base.ntp").write_text("library base\ntype Cup is Movabel\n")
    for name in "ab":
        (tmp_path / f"{name}.ntp").write_text(f"library {name}\nuse base\n")
    status, out, _ = output(capsys, "check", str(tmp_path / "a.ntp"), str(tmp_path / "b.ntp"))
    assert status == 1 and "\n1 error found" in out


@pytest.mark.parametrize(
    "words, message",
    [
        (["check", "none.ntp"], "there is no library at 'none.ntp'"),
        (["check"], "Missing argument 'FILE'"),
        (["chek", "a"], "there is no command 'chek'; did you mean 'check'? (available: check"),
        (["check", "a", "--statc"], "there is no option '--statc'; did you mean '--static'?"),
        (["check", "a", "--format", "yaml"], "'yaml' is not one of 'text', 'json', 'sarif'"),
        (["--static"], "there is no option '--static'"),
        (["trace", "shw"], "there is no command 'shw'; did you mean 'show'?"),
        (["trace", "show", "none.jsonl"], "none.jsonl: cannot be read"),
        (["trace", "show", "none.jsonl", "--depth", "0"], "--depth"),
        (["import-vat", "none.json"], "none.json: cannot be read"),
    ],
)
def test_misuse_is_one_sentence_and_status_two(
    capsys: pytest.CaptureFixture[str], words: list[str], message: str
) -> None:
    status, out, err = output(capsys, *words)
    assert (status, out) == (2, "")
    assert message in err and len(err.splitlines()) <= 2


@pytest.mark.parametrize("words", [["--help"], ["-h"], ["check", "--help"], ["trace", "-h"]])
def test_help_goes_to_standard_output(capsys: pytest.CaptureFixture[str], words: list[str]) -> None:
    status, out, err = output(capsys, *words)
    assert (status, err) == (0, "") and "Usage: ntp" in out


def test_no_command_lists_all_commands(capsys: pytest.CaptureFixture[str]) -> None:
    status, out, err = output(capsys)
    assert (status, out) == (2, "")
    assert all(name in err for name in COMMANDS)


@pytest.mark.parametrize(
    "error, status",
    [(NtpError("no such task"), 2), (TaskFailed("the tower fell"), 1), (KeyboardInterrupt(), 130)],
)
def test_an_exception_of_a_command_becomes_a_status_and_a_line(
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    error: BaseException,
    status: int,
) -> None:
    def examined(path: Path, texts: object) -> None:
        raise error

    monkeypatch.setattr("ntp_dsl.cli.commands.check.check_files", examined)
    found, out, err = output(capsys, "check", "block_stacking")
    assert (found, out, len(err.splitlines())) == (status, "", 1)
    assert str(error) in err


@pytest.mark.parametrize("debug", [False, True])
def test_an_unforeseen_error_is_a_sentence_that_asks_for_a_report(
    debug: bool, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def examined(path: Path, texts: object) -> None:
        raise ZeroDivisionError("a\x1b[2J")

    monkeypatch.setattr("ntp_dsl.cli.commands.check.check_files", examined)
    monkeypatch.setenv(app.DEBUG, "1" if debug else "")
    status = run(["check", "block_stacking"])
    told = capsys.readouterr()
    *_, sentence, advice = told.err.splitlines()
    assert (status, told.out) == (app.FAULT, "") and ("Traceback" in told.err) == debug
    assert "ntp check failed" in sentence and r"ZeroDivisionError: a\x1b[2J" in sentence
    assert "please report this" in advice and "NTP_DEBUG=1" in advice


def listen() -> None:
    """Undo what a shell does to the tests in its background: they, and their children, ignore the signal."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)


def test_ctrl_c_ends_with_one_line(tmp_path: Path) -> None:
    waits = tmp_path / "waits"
    os.mkfifo(waits)
    words = [sys.executable, "-m", "ntp_dsl", "import-vat", str(waits)]
    started = subprocess.Popen(words, stderr=subprocess.PIPE, text=True, preexec_fn=listen)
    with waits.open("w"):  # opens when the command is there to read it
        time.sleep(0.3)
        started.send_signal(signal.SIGINT)
        _, err = started.communicate(timeout=20)
    assert (started.returncode, err.splitlines()) == (130, [app.INTERRUPTION])


@pytest.mark.parametrize(
    "words",
    [
        ["check", "--static", "block_stacking"],
        ["trace", "show", "none.jsonl"],
        ["trace", "diff", "none.jsonl", "none.jsonl"],
    ],
)
def test_light_commands_answer_at_once(words: list[str]) -> None:
    """Measure processor time, the best of three, so that other load does not count."""
    best = min(processor_seconds(words) for _ in range(3))
    assert best < 0.8  # some .3 on a machine at rest; the bound allows for a busy one


def processor_seconds(words: list[str]) -> float:
    before = os.times()
    subprocess.run([sys.executable, "-m", "ntp_dsl", *words], capture_output=True, check=False)
    after = os.times()
    return after.children_user - before.children_user
