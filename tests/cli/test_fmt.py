"""`ntp fmt`: files are put into canonical layout, or left unchanged with the reason."""

from __future__ import annotations

import io
from pathlib import Path

import pytest

from ntp_dsl.cli.app import run

ROUGH = "library  a # why\nuse tabletop\ntype Cup is  Movable\n"
NEAT = "library a  # why\n\nuse tabletop\n\ntype Cup is Movable\n"


@pytest.fixture
def rough(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    path = tmp_path / "a.ntp"
    path.write_text(ROUGH)
    return path


def test_a_formatted_file_is_not_changed_again(capsys: pytest.CaptureFixture[str], rough: Path) -> None:
    assert run(["fmt", str(rough)]) == 0
    assert (rough.read_text(), capsys.readouterr().out) == (NEAT, "formatted a.ntp\n")
    assert run(["fmt", str(rough), "--check"]) == 0
    assert run(["fmt", str(rough)]) == 0
    assert capsys.readouterr().out == ""


def test_all_libraries_of_a_folder_are_formatted(rough: Path) -> None:
    other = rough.with_name("b.ntp")
    other.write_text(ROUGH)
    assert run(["fmt", str(rough.parent)]) == 0
    assert rough.read_text() == other.read_text() == NEAT


@pytest.mark.parametrize("option", ["--check", "--diff"])
def test_an_unformatted_file_is_reported_and_left(
    capsys: pytest.CaptureFixture[str], rough: Path, option: str
) -> None:
    assert run(["fmt", "a.ntp", option]) == 1
    out = capsys.readouterr().out
    assert rough.read_text() == ROUGH and "a.ntp: not in canonical layout; run `ntp fmt a.ntp`" in out
    assert ("+ type Cup is Movable" in out) == (option == "--diff")


def test_a_file_that_does_not_parse_is_left_and_the_others_are_formatted(
    capsys: pytest.CaptureFixture[str], rough: Path
) -> None:
    broken = rough.with_name("b.ntp")
    broken.write_text("library b\ntype\n")
    assert run(["fmt", str(broken), str(rough)]) == 1
    captured = capsys.readouterr()
    assert "b.ntp:2:5" in captured.err and "not formatted" in captured.err
    assert broken.read_text() == "library b\ntype\n" and rough.read_text() == NEAT


def set_standard_input(monkeypatch: pytest.MonkeyPatch, text: str) -> None:
    monkeypatch.setattr("sys.stdin", io.TextIOWrapper(io.BytesIO(text.encode())))


def test_standard_input_goes_to_standard_output(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    set_standard_input(monkeypatch, ROUGH.replace("\n", "\r\n"))
    assert run(["fmt", "-"]) == 0
    assert capsys.readouterr().out == NEAT
    set_standard_input(monkeypatch, "type\n")
    assert run(["fmt", "-"]) == 1
    assert capsys.readouterr().out == ""


def test_standard_input_is_formatted_alone(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["fmt", "-", "a.ntp"]) == 2
    assert "ntp fmt -" in capsys.readouterr().err
